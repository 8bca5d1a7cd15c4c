// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/protocol.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_engine/two_mass_lanes.hpp"
#include "pusht_policy/network_policy.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/temporary_folder.hpp"
#include "sim2sim_protocol/divergence.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/flight.hpp"
#include "sim2sim_protocol/reference_cache.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/runner.hpp"

namespace sim2sim {
namespace {

using ::testing::HasSubstr;

/// A world where the tee is led to the target at a speed [m/s] whatever the action, and turns to yaw 0 at once.
class LedWorld : public pusht::Simulator {
 public:
  /// The speed depends on the initial state.
  using Speed = std::function<double(const pusht::WorldState&)>;
  explicit LedWorld(Speed speed) : speed_from_(std::move(speed)) {}

 private:
  void doReset(const pusht::WorldState& state) override {
    state_ = state;
    speed_ = speed_from_(state);
  }
  void doStep(const pusht::Action& action) override {
    state_.pusher_position += pusht::kControlStep * Eigen::Vector2d(action[0], action[1]);
    const double distance = state_.tee_position.norm();
    const double left = std::max(0.0, distance - pusht::kControlStep * speed_);
    state_.tee_position *= left / std::max(distance, 1e-12);
    state_.tee_yaw = 0.0;
  }
  pusht::WorldState doState() const override { return state_; }

  Speed speed_from_;
  double speed_ = 0.0;
  pusht::WorldState state_;
};

/// Answers every query with the same action, and notes how many rows it was asked at once.
class ConstantPolicy : public pusht::Policy {
 public:
  explicit ConstantPolicy(pusht::Action action, std::size_t* largest_batch = nullptr)
      : action_(action), largest_batch_(largest_batch) {}
  void act(pusht::Span<const Query> queries, pusht::Span<pusht::Action> actions) override {
    if (largest_batch_ != nullptr) {
      *largest_batch_ = std::max(*largest_batch_, queries.size());
    }
    std::fill(actions.begin(), actions.end(), action_);
  }

 private:
  pusht::Action action_;
  std::size_t* largest_batch_;
};

std::unique_ptr<pusht::Policy> idlePolicy() { return std::make_unique<ConstantPolicy>(pusht::Action{0.0F, 0.0F}); }
std::unique_ptr<pusht::Policy> expert() { return std::make_unique<pusht::ScriptedExpert>(); }

/// A world for each lane, with its tee at this speed.
std::unique_ptr<pusht::BatchSimulator> ledLanes(int lanes, const LedWorld::Speed& speed) {
  std::vector<std::unique_ptr<pusht::Simulator>> worlds(lanes);
  std::generate(worlds.begin(), worlds.end(), [&speed] { return std::make_unique<LedWorld>(speed); });
  return std::make_unique<pusht::SimulatorLanes>(std::move(worlds));
}

std::function<Worlds(int)> ledWorlds(const LedWorld::Speed& reference_speed, const LedWorld::Speed& engine_speed) {
  return [=](int lanes) {
    Worlds worlds;
    worlds[kReferenceClosed] = ledLanes(lanes, reference_speed);
    worlds[kEngineClosed] = ledLanes(lanes, engine_speed);
    worlds[kEngineReplay] = ledLanes(lanes, engine_speed);
    return worlds;
  };
}

std::function<Worlds(int)> ledWorlds(double reference_speed, double engine_speed) {
  return ledWorlds([=](const auto& /*state*/) { return reference_speed; },
                   [=](const auto& /*state*/) { return engine_speed; });
}

pusht::TwoMassParameters draggy() {
  pusht::TwoMassParameters parameters;
  parameters.block_damp = 20.0;
  return parameters;
}

/// The engine against itself with other parameters.
Worlds enginePairs(int lanes) {
  return {std::make_unique<pusht::TwoMassLanes>(lanes, draggy()), std::make_unique<pusht::TwoMassLanes>(lanes),
          std::make_unique<pusht::TwoMassLanes>(lanes)};
}

/// The engine against itself.
Worlds sameEngines(int lanes) {
  return {std::make_unique<pusht::TwoMassLanes>(lanes), std::make_unique<pusht::TwoMassLanes>(lanes),
          std::make_unique<pusht::TwoMassLanes>(lanes)};
}

const std::function<bool()> kNeverStop = [] { return false; };

std::vector<EpisodeResult> run(const Protocol& protocol, const WorkerFactory& factory, int threads = 1,
                               const ReferenceCache* references = nullptr) {
  std::vector<EpisodeResult> episodes(static_cast<std::size_t>(protocol.episodes));
  int delivered = 0;
  runProtocol(
      protocol, factory, threads, references,
      [&](const Episode& episode) {
        EXPECT_EQ(episode.index(), protocol.first_episode + delivered) << "in order";
        episodes.at(static_cast<std::size_t>(delivered++)) = episode.result();
      },
      kNeverStop);
  EXPECT_EQ(delivered, protocol.episodes);
  return episodes;
}

/// Steps until the tee, led at `speed` from `distance`, has been in tolerance for five control steps.
int stepsToSuccess(double distance, double speed) {
  const int arrival = static_cast<int>(std::floor((distance - pusht::kPositionTolerance) / (speed * 0.1))) + 1;
  return arrival + pusht::kSuccessHold - 1;
}

TEST(Protocol, EndsAtSuccessOrAtTheHorizon) {
  Protocol protocol;
  protocol.episodes = 20;
  for (const EpisodeResult& episode : run(protocol, {ledWorlds(0.05, 0.001), idlePolicy})) {
    const double distance = protocol.initialState(episode.index).tee_position.norm();
    const RolloutResult& reference = episode.rollouts[kReferenceClosed];
    EXPECT_TRUE(reference.success);
    EXPECT_EQ(reference.steps, stepsToSuccess(distance, 0.05));
    EXPECT_FALSE(episode.rollouts[kEngineClosed].success) << "0.03 m in 300 steps is not enough";
    EXPECT_EQ(episode.rollouts[kEngineClosed].steps, pusht::kHorizon);
    EXPECT_EQ(episode.rollouts[kEngineReplay].steps, reference.steps) << "the replay has the reference's length";
  }
}

/// The tees move on one line, so the divergence has a closed form: the speeds' difference times the time.
TEST(Protocol, DivergenceIsTheMeanOverCommonStepsStartIncluded) {
  Protocol protocol;
  protocol.episodes = 3;
  protocol.horizon = 10;
  for (const EpisodeResult& episode : run(protocol, {ledWorlds(0.04, 0.01), idlePolicy})) {
    const RolloutResult& replay = episode.rollouts[kEngineReplay];
    const double mean_step = (0.0 + 10.0) / 2.0;  // over steps 0 to 10
    EXPECT_NEAR(replay.at("mean_position_divergence"), (0.04 - 0.01) * 0.1 * mean_step, 1e-12);
    EXPECT_NEAR(replay.at("mean_angle_divergence"), 0.0, 1e-12) << "both turn at once";
    EXPECT_TRUE(std::isnan(episode.rollouts[kReferenceClosed].at("mean_position_divergence")));
  }
}

/// Tees 4 mm further apart in each control step leave the bound of 30 mm in the eighth, in closed and in open loop.
TEST(Protocol, EveryRolloutOfTheEngineHasAFirstDivergence) {
  Protocol protocol;
  protocol.episodes = 2;
  protocol.horizon = 12;
  for (const EpisodeResult& episode : run(protocol, {ledWorlds(0.05, 0.01), idlePolicy})) {
    EXPECT_FALSE(episode.rollouts[kReferenceClosed].first_divergence);
    for (const Mode mode : {kEngineClosed, kEngineReplay}) {
      ASSERT_TRUE(episode.rollouts[mode].first_divergence) << mode;
      EXPECT_EQ(episode.rollouts[mode].first_divergence->step, 8) << mode;
    }
  }
}

TEST(Protocol, HeldOutSeeds) {
  Protocol protocol;
  protocol.seed = 7;
  protocol.episodes = 3;
  const auto episodes = run(protocol, {ledWorlds(0.1, 0.1), idlePolicy});
  EXPECT_EQ(episodes[0].seed, 10007U);
  EXPECT_EQ(episodes[2].seed, 10009U);
}

/// A run can be split: its parts have the rows of the whole.
TEST(Protocol, PartsOfARunAreTheRun) {
  Protocol protocol;
  protocol.seed = 7;
  protocol.episodes = 10;
  const auto whole = run(protocol, {enginePairs, expert});
  protocol.episodes = 4;
  auto parts = run(protocol, {enginePairs, expert});
  protocol.first_episode = 4;
  protocol.episodes = 6;
  const auto rest = run(protocol, {enginePairs, expert});
  parts.insert(parts.end(), rest.begin(), rest.end());
  EXPECT_EQ(episodesCsv(protocol, parts), episodesCsv(protocol, whole));
}

/// The replay gets the reference's actions: in the same engine it is the reference, bit for bit.
TEST(Protocol, ReplayInTheSameSimulatorDoesNotDiverge) {
  Protocol protocol;
  protocol.episodes = 10;
  for (const EpisodeResult& episode : run(protocol, {sameEngines, expert})) {
    EXPECT_EQ(episode.rollouts[kEngineReplay].at("mean_position_divergence"), 0.0);
    EXPECT_EQ(episode.rollouts[kEngineReplay].at("mean_angle_divergence"), 0.0);
    EXPECT_EQ(episode.rollouts[kEngineClosed].steps, episode.rollouts[kReferenceClosed].steps);
    EXPECT_EQ(episode.rollouts[kEngineClosed].at("final_position_error"),
              episode.rollouts[kReferenceClosed].at("final_position_error"));
  }
}

/// Many episodes in flight give what one after the other, by hand, gives. The expert has memory.
TEST(Protocol, EpisodesInFlightDoNotDisturbEachOther) {
  Protocol protocol;
  protocol.episodes = 2 * kEpisodesInFlight + 3;
  for (const EpisodeResult& episode : run(protocol, {enginePairs, expert})) {
    const pusht::WorldState start = protocol.initialState(episode.index);
    pusht::TwoMassEngine reference(draggy());
    pusht::TwoMassEngine engine;
    const pusht::Rollout expected = pusht::runClosedLoop(reference, start, *expert(), protocol.horizon);
    EXPECT_EQ(episode.rollouts[kReferenceClosed].steps, expected.steps());
    EXPECT_EQ(episode.rollouts[kReferenceClosed].success, expected.success());
    EXPECT_EQ(episode.rollouts[kReferenceClosed].at("final_position_error"), expected.error().position);
    pusht::Rollout replay = pusht::begin(engine, start);
    for (const pusht::Action& action : expected.trace().actions) {
      pusht::advance(replay, engine, action);
    }
    EXPECT_EQ(episode.rollouts[kEngineReplay].at("mean_position_divergence"),
              meanDivergence(expected.trace(), replay.trace()).position);
  }
}

TEST(Protocol, ResultsDoNotDependOnTheNumberOfThreads) {
  Protocol protocol;
  protocol.episodes = 37;
  const std::string alone = episodesCsv(protocol, run(protocol, {enginePairs, expert}));
  for (const int threads : {2, 3, 4, 16}) {
    EXPECT_EQ(episodesCsv(protocol, run(protocol, {enginePairs, expert}, threads)), alone) << threads << " threads";
  }
}

/// Barrier at which threads wait for each other.
class Meeting {
 public:
  explicit Meeting(int expected) : expected_(expected) {}

  /// Returns whether all came.
  bool join() {
    std::unique_lock<std::mutex> lock(mutex_);
    ++arrived_;
    all_here_.notify_all();
    return all_here_.wait_for(lock, std::chrono::seconds(30), [this] { return arrived_ >= expected_; });
  }

 private:
  const int expected_;
  int arrived_ = 0;
  std::mutex mutex_;
  std::condition_variable all_here_;
};

/// Acts only once all threads have a policy that acts.
class MeetingPolicy : public pusht::Policy {
 public:
  explicit MeetingPolicy(Meeting& meeting) : meeting_(meeting) {}
  void act(pusht::Span<const Query> /*queries*/, pusht::Span<pusht::Action> actions) override {
    if (!met_) {
      met_ = meeting_.join();
      EXPECT_TRUE(met_) << "a thread did not take part";
    }
    std::fill(actions.begin(), actions.end(), pusht::Action{});
  }

 private:
  Meeting& meeting_;
  bool met_ = false;
};

/// However few cores there are, and however few episodes.
/// The engine's world alone, in which the replay runs too.
Worlds withoutReplay(Worlds worlds) {
  worlds[kEngineReplay] = nullptr;
  return worlds;
}

TEST(Protocol, AReplayAfterTheClosedLoopIsTheSame) {
  Protocol protocol;
  protocol.episodes = 5;
  protocol.reanchor = {5};
  WorkerFactory one_world{[](int lanes) { return withoutReplay(enginePairs(lanes)); }, expert};
  const std::string csv = episodesCsv(protocol, run(protocol, {enginePairs, expert}));
  EXPECT_EQ(episodesCsv(protocol, run(protocol, one_world)), csv);
  one_world.one_at_a_time = true;
  EXPECT_EQ(episodesCsv(protocol, run(protocol, one_world, 2)), csv);
}

TEST(Protocol, OneAtATimeHasOneWorld) {
  Protocol protocol;
  protocol.episodes = 5;
  int made = 0;
  const auto worlds = [&](int lanes) {
    made += lanes;
    return sameEngines(lanes);
  };
  run(protocol, {worlds, idlePolicy, {}, true}, 4);
  EXPECT_EQ(made, 1);
}

/// A world that starts a little elsewhere each time.
class Drifting : public pusht::Simulator {
 private:
  void doReset(const pusht::WorldState& state) override {
    state_ = state;
    state_.tee_position.x() += 1e-9 * ++resets_;
  }
  void doStep(const pusht::Action& /*action*/) override {}
  pusht::WorldState doState() const override { return state_; }

  int resets_ = 0;
  pusht::WorldState state_;
};

TEST(Protocol, AReplayAfterTheClosedLoopMustStartAsItDid) {
  Protocol protocol;
  protocol.horizon = 3;
  const auto worlds = [](int /*lanes*/) {
    return withoutReplay(
        worldsOf(std::make_unique<pusht::TwoMassEngine>(), std::make_unique<Drifting>(), std::make_unique<Drifting>()));
  };
  EXPECT_EQ(pusht::testing::refusalOf<pusht::SimulationFault>([&] {
              run(protocol, {worlds, idlePolicy, {}, true});
            }),
            "episode 0 (spawn seed 10000), engine_replay, step 0: the second reset to the same state leads to another: "
            "must lead to the same bits");
}

TEST(Protocol, AllThreadsTakePart) {
  constexpr int kThreads = 4;
  Meeting meeting(kThreads);
  Protocol protocol;
  protocol.episodes = kThreads;
  protocol.horizon = 5;
  run(protocol, {enginePairs, [&] { return std::make_unique<MeetingPolicy>(meeting); }}, kThreads);
}

TEST(Protocol, AsksThePolicyForManyRolloutsAtOnce) {
  Protocol protocol;
  protocol.episodes = 3 * kEpisodesInFlight;
  std::size_t largest_batch = 0;
  const auto make_policy = [&] { return std::make_unique<ConstantPolicy>(pusht::Action{0.0F, 0.0F}, &largest_batch); };
  run(protocol, {ledWorlds(0.05, 0.05), make_policy});
  EXPECT_EQ(largest_batch, 2U * kEpisodesInFlight);
}

TEST(Protocol, StopsWhenAsked) {
  for (const int threads : {1, 3}) {
    Protocol protocol;
    protocol.episodes = 1000;
    std::atomic<int> delivered = 0;
    runProtocol(
        protocol, {ledWorlds(0.05, 0.05), idlePolicy}, threads, nullptr, [&](const Episode&) { ++delivered; },
        [&] { return delivered >= 5; });
    EXPECT_EQ(delivered, 5);
  }
}

/// F7: never data, and the message says where.
/// The first episode takes the whole horizon, the others a few steps. They overtake it, but not without bound.
TEST(Protocol, FinishedEpisodesThatWaitForDeliveryAreBounded) {
  Protocol protocol;
  protocol.episodes = 1000;
  protocol.floor = false;
  int begun = 0;
  const pusht::WorldState first = protocol.initialState(0);
  const auto speed = [&](const pusht::WorldState& state) { return state == first ? 0.0 : 1.0; };
  const auto counted = [&](const pusht::WorldState& state) {
    ++begun;
    return speed(state);
  };
  int begun_before_the_first = 0;
  const auto deliver = [&](const Episode& episode) {
    EXPECT_EQ(episode.index(), 0);
    EXPECT_EQ(episode.steps(), pusht::kHorizon);
    begun_before_the_first = begun;
  };
  runProtocol(protocol, {ledWorlds(counted, speed), idlePolicy}, 1, nullptr, deliver,
              [&] { return begun_before_the_first > 0; });
  EXPECT_EQ(begun_before_the_first, kEpisodesHeld);
}

/// A run that continues: the others are delivered in order, whatever is missing.
TEST(Protocol, FinishedEpisodesAreLeftOut) {
  Protocol protocol;
  protocol.episodes = 40;
  protocol.horizon = 10;
  for (const int threads : {1, 3}) {
    std::vector<int> delivered;
    runProtocol(protocol, {ledWorlds(0.05, 0.05), idlePolicy}, threads, nullptr,
                [&](const Episode& episode) { delivered.push_back(episode.index()); }, kNeverStop, {0, 1, 5, 38, 39});
    std::vector<int> expected(37);
    std::iota(expected.begin(), expected.end(), 2);
    expected.erase(expected.begin() + 3);
    expected.resize(35);
    EXPECT_EQ(delivered, expected);
  }
}

TEST(Protocol, AnActionThatIsNotFiniteFailsTheEpisodeByName) {
  Protocol protocol;
  protocol.episodes = 1;
  const auto make_policy = [] {
    return std::make_unique<ConstantPolicy>(pusht::Action{std::numeric_limits<float>::quiet_NaN(), 0.0F});
  };
  for (const int threads : {1, 2}) {
    try {
      run(protocol, {ledWorlds(0.05, 0.05), make_policy}, threads);
      FAIL();
    } catch (const pusht::Error& error) {
      EXPECT_EQ(error.exitCode(), pusht::ExitCode::kBadDependency);
      EXPECT_THAT(error.what(),
                  HasSubstr("episode 0 (spawn seed 10000), reference_closed, step 0: the policy's action"));
    }
  }
}

TEST(Protocol, ResultsDoNotDependOnTheKernelsInstructionSet) {
  Protocol protocol;
  protocol.episodes = 6;
  const auto rows_with = [&](pusht::InstructionSet instruction_set) {
    const auto make_policy = [&] { return pusht::NetworkPolicy::load(PUSHT_SHIPPED_POLICY, instruction_set); };
    return episodesCsv(protocol, run(protocol, {enginePairs, make_policy}));
  };
  const std::string baseline = rows_with(pusht::InstructionSet::kBaseline);
  for (const pusht::InstructionSet instruction_set : pusht::availableInstructionSets()) {
    EXPECT_EQ(rows_with(instruction_set), baseline) << toString(instruction_set);
  }
}

/// The reference of a second run is read, not rolled out, and the results are the same.
TEST(Protocol, TheReferenceIsRolledOutOnce) {
  const pusht::testing::TemporaryFolder folder;
  const ReferenceCache references(folder.path(), {{"reference", "draggy"}});
  Protocol protocol;
  protocol.episodes = 20;
  const std::string without = episodesCsv(protocol, run(protocol, {enginePairs, expert}));
  EXPECT_EQ(episodesCsv(protocol, run(protocol, {enginePairs, expert}, 2, &references)), without);

  const auto no_reference = [](int lanes) {
    Worlds worlds = enginePairs(lanes);
    worlds[kReferenceClosed] = nullptr;  // nor the floor
    return worlds;
  };
  for (const int threads : {1, 2}) {
    EXPECT_EQ(episodesCsv(protocol, run(protocol, {no_reference, expert}, threads, &references)), without);
  }
}

/// Tees on one line: what an engine makes in a control step is the speeds' difference times the time.
TEST(Probes, AReanchoredReplayStartsAnewFromTheReference) {
  Protocol protocol;
  protocol.episodes = 3;
  protocol.horizon = 12;
  protocol.floor = false;
  protocol.reanchor = {1, 5, 12};
  const double a_step = (0.04 - 0.01) * pusht::kControlStep;
  for (const EpisodeResult& episode : run(protocol, {ledWorlds(0.04, 0.01), idlePolicy})) {
    ASSERT_EQ(episode.rollouts.size(), kModeCount + 3U);
    const RolloutResult& each = episode.rollouts[rolloutOfProbe(0)];
    const RolloutResult& fives = episode.rollouts[rolloutOfProbe(1)];
    const RolloutResult& never = episode.rollouts[rolloutOfProbe(2)];
    EXPECT_NEAR(each.at("anchor_position_error"), a_step, 1e-12);
    EXPECT_NEAR(each.at("mean_position_divergence"), 12.0 * a_step / 13.0, 1e-12) << "zero at the start";
    EXPECT_NEAR(fives.at("anchor_position_error"), 5.0 * a_step, 1e-12) << "taken before the world is put back";
    EXPECT_NEAR(fives.at("mean_position_divergence"), (15.0 + 15.0 + 3.0) * a_step / 13.0, 1e-12);
    EXPECT_NEAR(never.at("anchor_position_error"), 12.0 * a_step, 1e-12);
    EXPECT_EQ(never.at("mean_position_divergence"), episode.rollouts[kEngineReplay].at("mean_position_divergence"));
    EXPECT_TRUE(std::isnan(episode.rollouts[kEngineReplay].at("anchor_position_error"))) << "it is never put back";
  }
}

TEST(Probes, TheNullModelRestsWhereItWasPutLast) {
  Protocol protocol;
  protocol.episodes = 3;
  protocol.horizon = 10;
  protocol.floor = false;
  protocol.reanchor = {5};
  const double a_step = 0.04 * pusht::kControlStep;  // of the reference
  for (const EpisodeResult& episode : run(protocol, {ledWorlds(0.04, 0.01), idlePolicy})) {
    EXPECT_NEAR(episode.rollouts[kEngineReplay].at("null_position_divergence"), 55.0 * a_step / 11.0, 1e-12);
    EXPECT_NEAR(episode.rollouts[rolloutOfProbe(0)].at("null_position_divergence"), 30.0 * a_step / 11.0, 1e-12);
  }
}

/// The tees go straight: after k steps they are k times as far apart as after one.
TEST(Probes, DivergenceOverAHorizonIsOfEpisodesThatLastLongEnough) {
  for (const int horizon :
       {kEarlySteps - 1, kEarlySteps, kFiveSecondSteps - 1, kFiveSecondSteps, kFiveSecondSteps + 10}) {
    Protocol protocol;
    protocol.episodes = 1;
    protocol.horizon = horizon;
    const EpisodeResult episode = run(protocol, {ledWorlds(0.02, 0.01), idlePolicy}).front();
    const auto expect_mean = [&](const char* quantity, int steps, double speed) {
      const double mean = episode.rollouts[kEngineReplay].at(quantity);
      if (horizon < steps) {
        EXPECT_TRUE(std::isnan(mean)) << quantity;
      } else {
        EXPECT_NEAR(mean, speed * pusht::kControlStep * steps / 2.0, 1e-12) << quantity << " of " << horizon;
      }
    };
    expect_mean("early_position_divergence", kEarlySteps, 0.01);
    expect_mean("early_5s_position_divergence", kFiveSecondSteps, 0.01);
    expect_mean("early_null_position_divergence", kEarlySteps, 0.02);
    expect_mean("early_5s_null_position_divergence", kFiveSecondSteps, 0.02);
  }
}

/// The floor of a world that only carries a shift along is that shift.
TEST(Probes, TheFloorIsTheReferenceFromAMovedStart) {
  Protocol protocol;
  protocol.episodes = 5;
  const std::vector<Probe> probes = protocol.probes();
  ASSERT_EQ(probes, floorProbes());
  const auto deliver = [&](const Episode& episode) {
    const pusht::Trace& reference = episode.rollout(kReferenceClosed).trace();
    for (std::size_t i = 0; i < probes.size(); ++i) {
      const pusht::Trace& floor = episode.probe(i).value();
      EXPECT_EQ(floor.states.size(), reference.states.size());
      EXPECT_EQ(floor.actions, reference.actions);
      EXPECT_NEAR(floor.states[0].tee_position.x() - reference.states[0].tee_position.x(), probes[i].tee_offset, 1e-15);
      EXPECT_EQ(floor.states[0].tee_position.y(), reference.states[0].tee_position.y());
    }
    const EpisodeResult result = episode.result();
    EXPECT_GT(result.rollouts[rolloutOfProbe(0)].at("mean_position_divergence"), 0.0);
    EXPECT_GT(result.rollouts[rolloutOfProbe(1)].at("mean_position_divergence"),
              result.rollouts[rolloutOfProbe(0)].at("mean_position_divergence"));
  };
  runProtocol(protocol, {sameEngines, expert}, 1, nullptr, deliver, kNeverStop);
}

/// World that rests, and counts draws and other starts.
class Drawn : public pusht::Simulator {
 public:
  Drawn(int& draws, int& others) : draws_(draws), others_(others) {}

 private:
  void doReset(const pusht::WorldState& state) override {
    ++others_;
    state_ = state;
  }
  void doSpawn(const pusht::WorldState& start, std::uint64_t /*seed*/) override {
    ++draws_;
    state_ = start;
  }
  void doStep(const pusht::Action& /*action*/) override {}
  pusht::WorldState doState() const override { return state_; }

  int& draws_;
  int& others_;
  pusht::WorldState state_;
};

/// Worlds are told of a draw, in which they may have more bits than a state has: not of a start that is moved or given.
TEST(Probes, StartFromADrawUnlessItIsMoved) {
  int draws = 0;
  int others = 0;
  const auto drawn = [&] { return std::make_unique<Drawn>(draws, others); };
  const auto worlds = [&](int /*lanes*/) { return worldsOf(drawn(), drawn(), drawn()); };
  Protocol protocol;
  protocol.episodes = 1;
  protocol.horizon = 10;
  protocol.reanchor = {5};
  run(protocol, {worlds, idlePolicy}, 1);
  EXPECT_EQ(draws, 3 + 1);   // the modes, the state-reset replay
  EXPECT_EQ(others, 2 + 1);  // the floors, the state after five steps
  draws = 0;
  run(protocol, {[&](int lanes) { return withoutReplay(worlds(lanes)); }, idlePolicy, {}, true}, 1);
  EXPECT_EQ(draws, 3 + 1) << "one world after the other";
  draws = 0;
  protocol.initial_states =
      std::make_shared<InitialStates>(std::vector{pusht::spawn(protocol.runTask().first_spawn_seed)}, 0);
  run(protocol, {worlds, idlePolicy}, 1);
  EXPECT_EQ(draws, 0);
}

/// Tees on one line: a variant's tee moves with its own speed, in closed loop until its own success.
TEST(Probes, AModelVariantIsTheReferenceWithAnotherModel) {
  Protocol protocol;
  protocol.episodes = 3;
  protocol.horizon = 12;
  protocol.floor = false;
  protocol.model_variants = {"speed=0.03", "speed=0.02"};
  protocol.closed_variants = {"speed=0.02"};
  const auto make_variants = [] {
    VariantWorlds worlds;
    worlds.push_back(ledLanes(1, [](const auto& /*state*/) { return 0.03; }));
    worlds.push_back(ledLanes(1, [](const auto& /*state*/) { return 0.02; }));
    return worlds;
  };
  for (const EpisodeResult& episode : run(protocol, {ledWorlds(0.04, 0.01), idlePolicy, make_variants})) {
    ASSERT_EQ(episode.rollouts.size(), kModeCount + 3U);
    const double mean_time = 6.0 * pusht::kControlStep;
    EXPECT_NEAR(episode.rollouts[rolloutOfProbe(0)].at("mean_position_divergence"), 0.01 * mean_time, 1e-12);
    EXPECT_NEAR(episode.rollouts[rolloutOfProbe(1)].at("mean_position_divergence"), 0.02 * mean_time, 1e-12);
    const RolloutResult& closed = episode.rollouts[rolloutOfProbe(2)];
    EXPECT_NEAR(closed.at("mean_position_divergence"), 0.02 * mean_time, 1e-12);
    EXPECT_FALSE(std::isnan(closed.at("final_position_error"))) << "a closed loop has an end of its own";
    EXPECT_TRUE(std::isnan(episode.rollouts[rolloutOfProbe(0)].at("final_position_error")));
  }
}

TEST(Probes, AreKnownByName) {
  RunOptions options;
  options.reanchor = {1, 20, 300};
  options.model_variants = {"timestep=0.005", "cone=elliptic:impratio=1e+06"};
  options.closed_variants = {kDefaultVariants, "timestep=0.005"};
  const std::vector<Probe> probes = probesOf(options);
  ASSERT_EQ(probes.size(), 8U);
  EXPECT_EQ(probes[6].name, "variant_cone=elliptic:impratio=1e+06");
  EXPECT_EQ(probes[7].name, "closed_variant_timestep=0.005");
  for (const Probe& probe : probes) {
    const Probe found = probeFrom(probe.name);
    EXPECT_EQ(found, probe);
    EXPECT_EQ(found.reset_every, probe.reset_every);
    EXPECT_EQ(found.tee_offset, probe.tee_offset);
    EXPECT_EQ(found.variant, probe.variant);
    EXPECT_EQ(found.closed, probe.closed);
  }
  EXPECT_EQ(reanchorFrom("1,5,20"), (std::vector<int>{1, 5, 20}));
  EXPECT_TRUE(reanchorFrom("").empty());
  for (const char* name : {"floor_1e-7", "engine_reanchored_", "engine_reanchored_0", "engine_reanchored_05", "",
                           "variant_", "variant_default", "closed_variant_cone", "variant_a=b,c=d"}) {
    EXPECT_THROW(probeFrom(name), pusht::InvalidInput) << name;
  }
  for (const char* list : {"1,x", "1,,5", "1,5,", "1.5", " 1"}) {
    EXPECT_THROW(reanchorFrom(list), pusht::InvalidInput) << list;
  }
  for (const std::vector<int>& every : {std::vector{0}, std::vector{301}, std::vector{5, 5}}) {
    options.reanchor = every;
    EXPECT_THROW(probesOf(options), pusht::InvalidInput) << every.front();
  }
  for (const char* list : {"timestep", "a=b,", "a=b/c", "a=b c", "=b", "a=b:"}) {
    EXPECT_THROW(modelVariantsFrom(list), pusht::InvalidInput) << list;
  }
  EXPECT_EQ(modelVariantsFrom("default,a=1:b=x"), (std::vector<std::string>{"default", "a=1:b=x"}));
  EXPECT_TRUE(modelVariantsFrom("").empty());
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
  EXPECT_EQ(refusal([](Protocol& p) { p.bound_angle = -1.0; }), "bound angle -1.0: must be finite and above 0 [rad]");
  EXPECT_EQ(refusal([](Protocol& p) { p.bound_position = std::nan(""); }),
            "bound position nan: must be finite and above 0 [m]");
  EXPECT_EQ(refusal([](Protocol& p) { p.until_decided = 1.5; }), "until_decided 1.5: must be above 0 and at most 1");
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
