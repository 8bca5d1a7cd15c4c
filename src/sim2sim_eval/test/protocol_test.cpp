// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/protocol.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"
#include "sim2sim_eval/report.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;

/// A world where the tee is led to the target at `speed` [m/s] whatever the action, and turns to yaw 0 at once.
class LedWorld : public pusht::Simulator {
 public:
  explicit LedWorld(double speed) : speed_(speed) {}

 private:
  void doReset(const pusht::WorldState& state) override { state_ = state; }
  void doStep(const pusht::Action& action) override {
    state_.pusher_position += pusht::kControlStep * Eigen::Vector2d(action[0], action[1]);
    const double distance = state_.tee_position.norm();
    const double left = std::max(0.0, distance - pusht::kControlStep * speed_);
    state_.tee_position *= left / std::max(distance, 1e-12);
    state_.tee_yaw = 0.0;
  }
  pusht::WorldState doState() const override { return state_; }

  double speed_;
  pusht::WorldState state_;
};

/// Answers every query with the same action, and counts how many rows it was asked at once.
class ConstantPolicy : public pusht::Policy {
 public:
  explicit ConstantPolicy(pusht::Action action) : action_(action) {}
  void act(pusht::Span<const Query> queries, pusht::Span<pusht::Action> actions) override {
    largest_batch = std::max(largest_batch, queries.size());
    std::fill(actions.begin(), actions.end(), action_);
  }
  std::size_t largest_batch = 0;

 private:
  pusht::Action action_;
};

const std::function<bool()> kNeverStop = [] { return false; };

std::vector<EpisodeResult> run(const Protocol& protocol, const std::function<Worlds()>& make_worlds,
                               pusht::Policy& policy) {
  std::vector<EpisodeResult> episodes(static_cast<std::size_t>(protocol.episodes));
  int delivered = 0;
  runProtocol(
      protocol, make_worlds, policy,
      [&](const Episode& episode) {
        episodes.at(static_cast<std::size_t>(episode.index() - protocol.first_episode)) = episode.result();
        ++delivered;
      },
      kNeverStop);
  EXPECT_EQ(delivered, protocol.episodes);
  return episodes;
}

Worlds ledWorlds(double reference_speed, double engine_speed) {
  return {std::make_unique<LedWorld>(reference_speed), std::make_unique<LedWorld>(engine_speed),
          std::make_unique<LedWorld>(engine_speed)};
}

Worlds enginePairs() {
  pusht::TwoMassParameters draggy;
  draggy.block_damp = 20.0;
  return {std::make_unique<pusht::TwoMassEngine>(draggy), std::make_unique<pusht::TwoMassEngine>(),
          std::make_unique<pusht::TwoMassEngine>()};
}

/// Steps until the tee, led at `speed` from `distance`, has been in tolerance for five control steps.
int stepsToSuccess(double distance, double speed) {
  const int arrival = static_cast<int>(std::floor((distance - pusht::kPositionTolerance) / (speed * 0.1))) + 1;
  return arrival + pusht::kSuccessHold - 1;
}

TEST(Protocol, EndsAtSuccessOrAtTheHorizon) {
  Protocol protocol;
  protocol.episodes = 20;
  ConstantPolicy policy({0.0F, 0.0F});
  for (const EpisodeResult& episode : run(
           protocol, [] { return ledWorlds(0.05, 0.001); }, policy)) {
    const double distance = pusht::spawn(episode.seed).tee_position.norm();
    const RolloutResult& reference = episode.modes[kReferenceClosed];
    EXPECT_TRUE(reference.success);
    EXPECT_EQ(reference.steps, stepsToSuccess(distance, 0.05));
    EXPECT_FALSE(episode.modes[kEngineClosed].success) << "0.03 m in 300 steps is not enough";
    EXPECT_EQ(episode.modes[kEngineClosed].steps, pusht::kHorizon);
    EXPECT_EQ(episode.modes[kEngineReplay].steps, reference.steps) << "the replay has the reference's length";
  }
}

/// The tees move on one line, so the divergence has a closed form: the speeds' difference times the time.
TEST(Protocol, DivergenceIsTheMeanOverCommonStepsStartIncluded) {
  Protocol protocol;
  protocol.episodes = 3;
  protocol.horizon = 10;
  ConstantPolicy policy({0.0F, 0.0F});
  for (const EpisodeResult& episode : run(
           protocol, [] { return ledWorlds(0.04, 0.01); }, policy)) {
    const auto& divergence = episode.modes[kEngineReplay].mean_divergence;
    ASSERT_TRUE(divergence);
    const double mean_step = (0.0 + 10.0) / 2.0;  // over steps 0 to 10
    EXPECT_NEAR(divergence->position, (0.04 - 0.01) * 0.1 * mean_step, 1e-12);
    EXPECT_NEAR(divergence->angle, 0.0, 1e-12) << "both turn at once";
    EXPECT_FALSE(episode.modes[kReferenceClosed].mean_divergence);
  }
}

TEST(Protocol, HeldOutSeeds) {
  Protocol protocol;
  protocol.seed = 7;
  protocol.episodes = 3;
  ConstantPolicy policy({0.0F, 0.0F});
  const auto episodes = run(
      protocol, [] { return ledWorlds(0.1, 0.1); }, policy);
  EXPECT_EQ(episodes[0].seed, 10007U);
  EXPECT_EQ(episodes[2].seed, 10009U);
}

/// A run can be split: its parts have the rows of the whole.
TEST(Protocol, PartsOfARunAreTheRun) {
  Protocol protocol;
  protocol.seed = 7;
  protocol.episodes = 10;
  pusht::ScriptedExpert expert;
  const auto whole = run(protocol, enginePairs, expert);
  protocol.episodes = 4;
  auto parts = run(protocol, enginePairs, expert);
  protocol.first_episode = 4;
  protocol.episodes = 6;
  const auto rest = run(protocol, enginePairs, expert);
  parts.insert(parts.end(), rest.begin(), rest.end());
  EXPECT_EQ(episodesCsv(parts), episodesCsv(whole));
}

/// The replay gets the reference's actions: in the same engine it is the reference, bit for bit.
TEST(Protocol, ReplayInTheSameSimulatorDoesNotDiverge) {
  Protocol protocol;
  protocol.episodes = 10;
  pusht::ScriptedExpert expert;
  const auto make_worlds = [] {
    return Worlds{std::make_unique<pusht::TwoMassEngine>(), std::make_unique<pusht::TwoMassEngine>(),
                  std::make_unique<pusht::TwoMassEngine>()};
  };
  for (const EpisodeResult& episode : run(protocol, make_worlds, expert)) {
    EXPECT_EQ(episode.modes[kEngineReplay].mean_divergence->position, 0.0);
    EXPECT_EQ(episode.modes[kEngineReplay].mean_divergence->angle, 0.0);
    EXPECT_EQ(episode.modes[kEngineClosed].steps, episode.modes[kReferenceClosed].steps);
    EXPECT_EQ(episode.modes[kEngineClosed].final_error.position, episode.modes[kReferenceClosed].final_error.position);
  }
}

/// Many episodes in flight give what one after the other, by hand, gives. The expert has memory.
TEST(Protocol, EpisodesInFlightDoNotDisturbEachOther) {
  Protocol protocol;
  protocol.episodes = 2 * kEpisodesInFlight + 3;
  pusht::ScriptedExpert expert;
  const auto episodes = run(protocol, enginePairs, expert);
  for (const EpisodeResult& episode : episodes) {
    const Worlds worlds = enginePairs();
    pusht::Rollout reference(*worlds.reference, pusht::spawn(episode.seed), expert.begin());
    pusht::runClosedLoop(reference, expert, protocol.horizon);
    EXPECT_EQ(episode.modes[kReferenceClosed].steps, reference.steps());
    EXPECT_EQ(episode.modes[kReferenceClosed].success, reference.success());
    EXPECT_EQ(episode.modes[kReferenceClosed].final_error.position, reference.error().position);
    pusht::Rollout replay(*worlds.replay, pusht::spawn(episode.seed));
    for (const pusht::Action& action : reference.trace().actions) {
      replay.advance(action);
    }
    EXPECT_EQ(episode.modes[kEngineReplay].mean_divergence->position,
              meanDivergence(reference.trace(), replay.trace()).position);
  }
}

TEST(Protocol, AsksThePolicyForManyRolloutsAtOnce) {
  Protocol protocol;
  protocol.episodes = 3 * kEpisodesInFlight;
  ConstantPolicy policy({0.0F, 0.0F});
  run(
      protocol, [] { return ledWorlds(0.05, 0.05); }, policy);
  EXPECT_EQ(policy.largest_batch, 2U * kEpisodesInFlight);
}

TEST(Protocol, StopsWhenAsked) {
  Protocol protocol;
  protocol.episodes = 1000;
  ConstantPolicy policy({0.0F, 0.0F});
  int delivered = 0;
  runProtocol(
      protocol, [] { return ledWorlds(0.05, 0.05); }, policy, [&](const Episode&) { ++delivered; },
      [&] { return delivered >= 5; });
  EXPECT_GE(delivered, 5);
  EXPECT_LT(delivered, 5 + kEpisodesInFlight);
}

/// F7: never data, and the message says where.
TEST(Protocol, AnActionThatIsNotFiniteFailsTheEpisodeByName) {
  Protocol protocol;
  protocol.episodes = 1;
  ConstantPolicy policy({std::numeric_limits<float>::quiet_NaN(), 0.0F});
  try {
    run(
        protocol, [] { return ledWorlds(0.05, 0.05); }, policy);
    FAIL();
  } catch (const pusht::Error& error) {
    EXPECT_EQ(error.exitCode(), pusht::ExitCode::kBadDependency);
    EXPECT_THAT(error.what(), HasSubstr("episode 0 (spawn seed 10000), reference_closed, step 0: the policy's action"));
  }
}

TEST(Protocol, RefusesWhatItCannotRun) {
  const auto refusal = [](const std::function<void(Protocol&)>& change) -> std::string {
    Protocol protocol;
    change(protocol);
    try {
      protocol.validate();
    } catch (const pusht::InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal([](Protocol& p) { p.episodes = 0; }), HasSubstr("episodes 0: must be from 1 to 1000000"));
  EXPECT_THAT(refusal([](Protocol& p) { p.episodes = 1'000'000'000; }), HasSubstr("episodes 1000000000"));
  EXPECT_THAT(refusal([](Protocol& p) { p.horizon = 301; }), HasSubstr("horizon 301"));
  EXPECT_THAT(refusal([](Protocol& p) { p.seed = ~0ULL - 10'000; }), HasSubstr("seed 18446744073709541615"));
  EXPECT_THAT(refusal([](Protocol& p) { p.first_episode = -1; }), HasSubstr("first_episode -1: must be from 0"));
  EXPECT_THAT(refusal([](Protocol& p) {
                p.seed = ~0ULL - 10'060;
                p.first_episode = 20;
              }),
              HasSubstr("10000 + seed + first_episode + episodes must be below 2^64"));
  EXPECT_EQ(refusal([](Protocol& p) { p.seed = ~0ULL - 10'060; }), "");
}

TEST(DivergenceBySteps, WrapsAnglesAndStopsWithTheShorterTrace) {
  pusht::Trace a;
  pusht::Trace b;
  a.states.resize(3);
  b.states.resize(2);
  a.states[0].tee_yaw = 3.1;
  b.states[0].tee_yaw = -3.1;
  a.states[1].tee_position = {0.03, 0.0};
  b.states[1].tee_position = {0.0, 0.04};
  const auto steps = divergenceBySteps(a, b);
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_NEAR(steps[0].angle, 2.0 * pusht::kPi - 6.2, 1e-12);
  EXPECT_NEAR(steps[1].position, 0.05, 1e-15);
}

}  // namespace
}  // namespace sim2sim
