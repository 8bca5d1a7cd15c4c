// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/loop.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstddef>
#include <deque>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"

namespace pusht {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Settings = std::vector<std::pair<std::string, std::string>>;

ParameterSet loopWith(const Settings& settings) {
  ParameterSet loop = plainLoop();
  for (const auto& [name, value] : settings) {
    loop.set(name, value);
  }
  return loop;
}

/// Commands the pusher's coordinates, and keeps what it was asked.
class Echo : public Policy {
 public:
  explicit Echo(std::vector<Observation>& asked) : asked_(asked) {}

  void act(Span<const Query> queries, Span<Action> actions) override {
    for (std::size_t row = 0; row < queries.size(); ++row) {
      asked_.push_back(queries[row].observation);
      actions[row] = {queries[row].observation[0], queries[row].observation[1]};
    }
  }

 private:
  std::vector<Observation>& asked_;
};

/// A policy whose commands come `delay` steps late, as people write such a wrapper.
class Late : public Policy {
 public:
  Late(std::unique_ptr<Policy> policy, std::size_t delay) : policy_(std::move(policy)), delay_(delay) {}

  std::unique_ptr<Memory> begin(const Beginning& /*unused*/) const override {
    auto queue = std::make_unique<Queue>();
    queue->commands.resize(delay_);
    return queue;
  }

  void act(Span<const Query> queries, Span<Action> actions) override {
    for (std::size_t row = 0; row < queries.size(); ++row) {
      const Query query{queries[row].observation, nullptr};
      Action command{};
      policy_->act({&query, 1}, {&command, 1});
      auto& commands = static_cast<Queue*>(queries[row].memory)->commands;
      commands.push_back(command);
      actions[row] = commands.front();
      commands.pop_front();
    }
  }

 private:
  struct Queue : Memory {
    std::deque<Action> commands;
  };
  std::unique_ptr<Policy> policy_;
  std::size_t delay_;
};

class Constant : public Policy {
 public:
  explicit Constant(const Action& answer) : answer_(answer) {}
  void act(Span<const Query> /*unused*/, Span<Action> actions) override { actions[0] = answer_; }

 private:
  Action answer_;
};

/// Observation of step `step`: nothing in it is like that of another step.
Observation shown(int step) {
  Observation observation = observe(spawn(static_cast<std::uint64_t>(step)));
  observation[0] = 0.01F * static_cast<float>(step + 1);
  observation[1] = -0.02F * static_cast<float>(step + 1);
  return observation;
}

class Loops : public ::testing::Test {
 protected:
  std::unique_ptr<Policy> echo() { return std::make_unique<Echo>(asked_); }

  /// Commands of `policy` in a rollout of `steps` control steps.
  static std::vector<Action> drive(Policy& policy, int steps, const Beginning& beginning = {}) {
    const auto memory = policy.begin(beginning);
    std::vector<Action> commands;
    for (int step = 0; step < steps; ++step) {
      const Policy::Query query{shown(step), memory.get()};
      policy.act({&query, 1}, {&commands.emplace_back(), 1});
    }
    return commands;
  }

  std::vector<Action> drive(const Settings& settings, int steps, std::uint64_t seed = 0) {
    asked_.clear();
    return drive(*looped(echo(), loopWith(settings), plainLoop()), steps, {seed, 0, Role::kReference});
  }

  /// Commands of a policy that always answers alike.
  static std::vector<Action> driveConstant(const Action& answer, const Settings& settings, int steps) {
    return drive(*looped(std::make_unique<Constant>(answer), loopWith(settings), plainLoop()), steps);
  }

  std::vector<Observation> asked_;
};

TEST_F(Loops, APlainOneIsThePolicyItself) {
  auto policy = echo();
  const Policy* const itself = policy.get();
  EXPECT_EQ(looped(std::move(policy), plainLoop(), plainLoop()).get(), itself);
}

TEST_F(Loops, ARoleThatIsPlainHasThePolicysActions) {
  const auto policy = looped(echo(), plainLoop(), loopWith({{"action_delay", "2"}, {"action_noise", "0.1"}}));
  EXPECT_EQ(drive(*policy, 5, {7, 0, Role::kReference}), drive(*echo(), 5));
  EXPECT_NE(drive(*policy, 5, {7, 0, Role::kEngine}), drive(*echo(), 5));
}

TEST_F(Loops, DelayOfActionsIsThatOfAWrappedPolicy) {
  for (const int delay : {1, 2, 7}) {
    Late late(echo(), static_cast<std::size_t>(delay));
    EXPECT_EQ(drive({{"action_delay", std::to_string(delay)}}, 12), drive(late, 12)) << delay;
  }
  EXPECT_THAT(drive({{"action_delay", "2"}}, 3), ElementsAre(Action{}, Action{}, Action{0.01F, -0.02F}));
}

TEST_F(Loops, DelayOfObservationsRepeatsTheFirst) {
  drive({{"observation_delay", "2"}}, 5);
  EXPECT_THAT(asked_, ElementsAre(shown(0), shown(0), shown(0), shown(1), shown(2)));
}

TEST_F(Loops, HoldAsksEveryFewSteps) {
  const std::vector<Action> commands = drive({{"hold", "3"}}, 7);
  EXPECT_THAT(asked_, ElementsAre(shown(0), shown(3), shown(6)));
  EXPECT_EQ(commands[2], commands[0]);
  EXPECT_EQ(commands[3], (Action{0.04F, -0.08F}));
}

TEST_F(Loops, ScaleIsOfTheClippedCommand) {
  EXPECT_THAT(driveConstant({4.0F, 0.5F}, {{"action_scale", "0.5"}}, 1), ElementsAre(Action{0.5F, 0.25F}));
}

TEST_F(Loops, WhatIsNotFiniteStaysSo) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  for (const Settings& settings : std::vector<Settings>{
           {{"action_scale", "0.5"}}, {{"action_scale", "0"}}, {{"action_noise", "0.1"}}, {{"hold", "2"}}}) {
    for (const float bad : {kInfinite, -kInfinite, std::numeric_limits<float>::quiet_NaN()}) {
      EXPECT_FALSE(isFinite(driveConstant({bad, 0.1F}, settings, 1).at(0))) << settings.begin()->first << ' ' << bad;
    }
  }
}

/// Mean and standard deviation.
std::pair<double, double> momentsOf(const std::vector<double>& values) {
  double sum = 0.0;
  double squares = 0.0;
  for (const double value : values) {
    sum += value;
    squares += value * value;
  }
  const double mean = sum / static_cast<double>(values.size());
  return {mean, std::sqrt(squares / static_cast<double>(values.size()) - mean * mean)};
}

TEST_F(Loops, NoiseHasItsDeviation) {
  constexpr int kSteps = 4000;
  constexpr double kMost = 4.0 / 63.0;  // four standard errors of a mean over 4000, in deviations
  std::vector<double> commands;
  for (const Action& command : driveConstant({}, {{"action_noise", "0.05"}}, kSteps)) {
    commands.push_back(command[0] / 0.05);
    commands.push_back(command[1] / 0.05);
  }
  std::vector<double> positions;
  std::vector<double> yaws;
  drive({{"observation_noise_position", "0.002"}, {"observation_noise_yaw", "0.1"}}, kSteps);
  for (int step = 0; step < kSteps; ++step) {
    const Observation truth = shown(step);
    const Observation& seen = asked_[static_cast<std::size_t>(step)];
    for (std::size_t i = 0; i < 4; ++i) {
      positions.push_back((seen[i] - truth[i]) / 0.002);
    }
    yaws.push_back(std::remainder(std::atan2(seen[4], seen[5]) - std::atan2(truth[4], truth[5]), 2.0 * M_PI) / 0.1);
    EXPECT_NEAR(std::hypot(seen[4], seen[5]), 1.0, 1e-6);
    EXPECT_TRUE(std::equal(truth.begin() + 6, truth.end(), seen.begin() + 6)) << "the target is known";
  }
  for (const auto& values : {commands, positions, yaws}) {
    const auto [mean, deviation] = momentsOf(values);
    EXPECT_NEAR(mean, 0.0, kMost);
    EXPECT_NEAR(deviation, 1.0, kMost);
  }
}

TEST_F(Loops, NoiseIsOfTheSeedAlone) {
  const Settings noise = {{"action_noise", "0.05"}};
  const std::vector<Action> commands = drive(noise, 6, 3);
  EXPECT_EQ(drive(noise, 6, 3), commands);
  EXPECT_NE(drive(noise, 6, 4), commands);
}

TEST_F(Loops, AParameterChangesNoOtherNoise) {
  const std::vector<Action> quiet = drive({}, 6, 3);
  const std::vector<Action> one = drive({{"action_noise", "0.01"}}, 6, 3);
  const std::vector<Action> two = drive({{"action_noise", "0.02"}, {"observation_noise_yaw", "0.3"}}, 6, 3);
  for (std::size_t step = 0; step < quiet.size(); ++step) {
    EXPECT_NEAR(two[step][0] - quiet[step][0], 2.0F * (one[step][0] - quiet[step][0]), 1e-6F);
  }
}

TEST_F(Loops, NoiseOfZeroIsNone) {
  EXPECT_EQ(drive({{"hold", "2"}, {"action_noise", "0"}, {"observation_noise_yaw", "0.0"}}, 6),
            drive({{"hold", "2"}}, 6));
}

TEST_F(Loops, RowsDoNotDisturbEachOther) {
  const auto policy = looped(echo(), loopWith({{"hold", "2"}, {"action_delay", "1"}, {"action_noise", "0.1"}}),
                             loopWith({{"observation_delay", "3"}}));
  const std::vector<Beginning> beginnings = {{1, 0, Role::kReference}, {2, 0, Role::kEngine}, {3, 0, Role::kReference}};
  std::vector<std::unique_ptr<Policy::Memory>> memories;
  memories.reserve(beginnings.size());
  for (const Beginning& beginning : beginnings) {
    memories.push_back(policy->begin(beginning));
  }
  std::vector<std::vector<Action>> together(beginnings.size());
  for (int step = 0; step < 6; ++step) {
    std::vector<Policy::Query> queries;
    for (std::size_t row = 0; row < beginnings.size(); ++row) {
      if (step < 5 || row != 1) {  // one ends earlier
        queries.push_back({shown(step), memories[row].get()});
      }
    }
    std::vector<Action> actions(queries.size());
    policy->act(queries, actions);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      together[queries.size() == 3 || i == 0 ? i : 2].push_back(actions[i]);
    }
  }
  EXPECT_EQ(together[0], drive(*policy, 6, beginnings[0]));
  EXPECT_EQ(together[1], drive(*policy, 5, beginnings[1]));
  EXPECT_EQ(together[2], drive(*policy, 6, beginnings[2]));
}

/// A policy of gym_pusht that goes to one place and keeps the states it sees.
class ToAPlace : public Policy {
 public:
  ToAPlace(std::vector<Query>& asked, std::vector<WorldState>& states, std::vector<gym_pusht::State>& in_pixels)
      : asked_(asked), states_(states), in_pixels_(in_pixels) {}

  void act(Span<const Query> queries, Span<Action> actions) override {
    asked_.push_back(queries[0]);
    states_.push_back(*queries[0].state);
    if (queries[0].state_in_pixels != nullptr) {
      in_pixels_.push_back(*queries[0].state_in_pixels);
    }
    actions[0] = {300.0F, 200.0F};
  }

 private:
  std::vector<Query>& asked_;
  std::vector<WorldState>& states_;
  std::vector<gym_pusht::State>& in_pixels_;
};

class LoopsInPixels : public ::testing::Test {
 protected:
  /// Commands while the world shows `world`, step by step.
  std::vector<Action> drive(const Settings& settings, int steps = 3) {
    const auto policy =
        looped(std::make_unique<ToAPlace>(asked_, states_, in_pixels_), loopWith(settings), plainLoop(), gymPusht());
    const auto memory = policy->begin({});
    std::vector<Action> commands;
    for (int step = 0; step < steps; ++step) {
      world_.pusher_position.x() = 0.001 * step;  // 1 px a step
      const gym_pusht::State in_pixels = gym_pusht::fromTable(world_);
      const Policy::Query query{observe(world_, gymPusht()), memory.get(), &world_, &in_pixels};
      policy->act({&query, 1}, {&commands.emplace_back(), 1});
    }
    return commands;
  }

  WorldState world_ = gym_pusht::toTable({{256.0, 200.0}, {0.0, 0.0}, {280.0, 230.0}, 0.5});
  std::vector<Policy::Query> asked_;
  std::vector<WorldState> states_;
  std::vector<gym_pusht::State> in_pixels_;
};

TEST_F(LoopsInPixels, APusherWaitsWhereItIsForALateCommand) {
  EXPECT_THAT(drive({{"action_delay", "2"}}),
              ElementsAre(Action{256.0F, 200.0F}, Action{256.0F, 200.0F}, Action{300.0F, 200.0F}));
}

TEST_F(LoopsInPixels, ScaleIsOfTheWayToThePosition) {
  EXPECT_THAT(drive({{"action_scale", "0.5"}}),
              ElementsAre(Action{278.0F, 200.0F}, Action{278.5F, 200.0F}, Action{279.0F, 200.0F}));
}

TEST_F(LoopsInPixels, NoiseOfTheActuatorIsOfTheSpeed) {
  // 1 m/s: a spring of 100/s^2 and a damper of 20/s are even 200 px behind the target.
  constexpr int kSteps = 2000;
  std::vector<double> errors;
  for (const Action& command : drive({{"action_noise", "0.01"}}, kSteps)) {
    errors.push_back((command[0] - 300.0) / 2.0);
    errors.push_back((command[1] - 200.0) / 2.0);
  }
  EXPECT_NEAR(momentsOf(errors).second, 1.0, 4.0 / std::sqrt(2.0 * kSteps));
}

TEST_F(LoopsInPixels, NoiseOfTheSensorIsInObservationAndState) {
  constexpr int kSteps = 1000;
  drive({{"observation_noise_position", "0.003"}, {"observation_noise_yaw", "0.1"}}, kSteps);
  std::vector<double> errors;
  for (int step = 0; step < kSteps; ++step) {
    const Observation& seen = asked_[static_cast<std::size_t>(step)].observation;
    errors.push_back((seen[1] - 200.0) / 3.0);
    const Observation of_state = observe(states_[static_cast<std::size_t>(step)], gymPusht());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_NEAR(seen[i], of_state[i], 1e-4) << i;
    }
  }
  EXPECT_NEAR(momentsOf(errors).second, 1.0, 4.0 / std::sqrt(2.0 * kSteps));
  EXPECT_THAT(in_pixels_, IsEmpty()) << "bits that no sensor has";
}

TEST_F(LoopsInPixels, ADelayIsOfObservationAndState) {
  drive({{"observation_delay", "1"}}, 3);
  EXPECT_EQ(states_[1].pusher_position.x(), 0.0);
  EXPECT_EQ(states_[2].pusher_position.x(), 0.001);
  EXPECT_EQ(asked_[2].observation[0], 257.0F);
  EXPECT_EQ(in_pixels_[2].pusher, gym_pusht::fromTable(states_[2]).pusher);
}

TEST_F(Loops, HaveNamesThatSetWhatIsNotSetByName) {
  const ParameterSet tracker = loopWith({{"preset", "tracker"}});
  EXPECT_EQ(tracker.get<std::int64_t>("observation_delay"), 1);
  EXPECT_EQ(tracker.get<double>("observation_noise_position"), 0.002);
  EXPECT_EQ(tracker.get<double>("observation_noise_yaw"), 0.01);
  EXPECT_EQ(textOf(tracker), "tracker");
  EXPECT_EQ(textOf(loopWith({{"observation_delay", "2"}, {"preset", "tracker"}})), "tracker, observation_delay 2");
  EXPECT_EQ(textOf(loopWith({{"hold", "2"}})), "hold 2");
  EXPECT_EQ(textOf(plainLoop()), "");
  EXPECT_TRUE(isPlain(loopWith({{"preset", "none"}})));
  EXPECT_EQ(loopSettingFrom("tracker"), std::pair(std::string("preset"), std::string("tracker")));
  EXPECT_EQ(loopSettingFrom("hold=2"), std::pair(std::string("hold"), std::string("2")));
}

TEST_F(Loops, RefuseWhatIsOutOfRange) {
  const auto refusal = [](const std::string& name, const std::string& value) -> std::string {
    try {
      loopWith({{name, value}});
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal("hold", "0"), HasSubstr("from 1 to 100"));
  EXPECT_THAT(refusal("action_delay", "-1"), HasSubstr("action_delay -1"));
  EXPECT_THAT(refusal("action_noise", "nan"), HasSubstr("action_noise"));
  EXPECT_THAT(refusal("delay", "1"), HasSubstr("action_delay"));
  EXPECT_EQ(loopParameterOf("loop.hold"), "hold");
  EXPECT_EQ(loopParameterOf("looped"), "");
}

}  // namespace
}  // namespace pusht
