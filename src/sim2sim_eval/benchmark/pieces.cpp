// SPDX-License-Identifier: BSD-3-Clause
// Times the pieces of the protocol, each alone: engine, reference, every kind, policy, service, bag.
#include <benchmark/benchmark.h>
#include <pusht_msgs/Describe.h>
#include <pusht_msgs/Divergence.h>
#include <ros/ros.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bare_mujoco.hpp"
#include "pusht_engine/rigid_body_engine.hpp"
#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_engine/two_mass_lanes.hpp"
#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_policy/network_policy.hpp"
#include "pusht_policy/policy_choice.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/temporary_folder.hpp"
#include "sim2sim_protocol/runner.hpp"
#include "sim2sim_serving/bag_file.hpp"
#include "sim2sim_serving/installed_file.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace {

using benchmark::State;
using pusht::simd::kLaneCount;

// ---- Engine

/// Into the notch between bar and stem, where the pusher stays: two contacts, nearly always.
pusht::Action push(const pusht::WorldState& state) {
  constexpr double kCenter = pusht::kStemOffset * pusht::kStemMass / (pusht::kBarMass + pusht::kStemMass);  // [m]
  const Eigen::Vector2d center =
      state.tee_position + kCenter * Eigen::Vector2d(std::sin(state.tee_yaw), -std::cos(state.tee_yaw));
  const Eigen::Vector2d way = (center - state.pusher_position).normalized();
  return {static_cast<float>(way.x()), static_cast<float>(way.y())};
}

/// Trace of a world: the tee is pushed all the time, or the pusher rests out of reach.
pusht::Trace scenario(bool contact, std::uint64_t seed) {
  pusht::WorldState start = pusht::spawn(seed);
  if (!contact) {
    start.pusher_position.x() = 10.0;
  }
  pusht::TwoMassEngine engine;
  pusht::Rollout rollout = pusht::begin(engine, start);
  while (rollout.steps() < pusht::kHorizon) {
    pusht::advance(rollout, engine, contact ? push(engine.state()) : pusht::Action{});
  }
  return rollout.trace();
}

void engineSteps(State& state) {
  const pusht::Trace trace = scenario(state.range(0) != 0, 0);
  pusht::TwoMassEngine engine;
  for ([[maybe_unused]] auto _ : state) {
    engine.reset(trace.states.front());
    for (const pusht::Action& action : trace.actions) {
      engine.step(action);
    }
  }
  state.SetItemsProcessed(state.iterations() * pusht::kHorizon);
}
BENCHMARK(engineSteps)->Name("engine/free")->Arg(0);
BENCHMARK(engineSteps)->Name("engine/contact")->Arg(1);

void engineLanes(State& state) {
  std::vector<pusht::Trace> traces(kLaneCount);
  for (int lane = 0; lane < kLaneCount; ++lane) {
    traces[lane] = scenario(state.range(0) != 0, lane);
  }
  pusht::TwoMassLanes engine(kLaneCount);
  std::vector<std::optional<pusht::Action>> actions(kLaneCount);
  for ([[maybe_unused]] auto _ : state) {
    for (int lane = 0; lane < kLaneCount; ++lane) {
      engine.reset(lane, traces[lane].states.front());
    }
    for (int step = 0; step < pusht::kHorizon; ++step) {
      for (int lane = 0; lane < kLaneCount; ++lane) {
        actions[lane] = traces[lane].actions[step];
      }
      engine.step(actions);
    }
  }
  state.SetItemsProcessed(state.iterations() * pusht::kHorizon * kLaneCount);
}
BENCHMARK(engineLanes)->Name("engine_lanes/free")->Arg(0);
BENCHMARK(engineLanes)->Name("engine_lanes/contact")->Arg(1);

// ---- Reference: what the shipped policy does, by MuJoCo's own calls and through our world

std::shared_ptr<const pusht::MujocoScene> scene() {
  static const auto scene = std::make_shared<const pusht::MujocoScene>();
  return scene;
}

std::filesystem::path shippedPolicy() { return pusht::installedFile("pusht_policy", pusht::kShippedCheckpoint); }

const std::vector<pusht::Trace>& referenceTraces() {
  static const std::vector<pusht::Trace> traces = [] {
    constexpr int kEpisodes = 5;
    const auto policy = pusht::NetworkPolicy::load(shippedPolicy());
    pusht::MujocoWorld world(scene());
    std::vector<pusht::Trace> recorded(kEpisodes);
    for (int seed = 0; seed < kEpisodes; ++seed) {
      recorded[seed] = pusht::runClosedLoop(world, pusht::spawn(seed), *policy, pusht::kHorizon).trace();
    }
    return recorded;
  }();
  return traces;
}

std::int64_t stepsOf(const std::vector<pusht::Trace>& traces) {
  std::int64_t steps = 0;
  for (const pusht::Trace& trace : traces) {
    steps += static_cast<std::int64_t>(trace.steps());
  }
  return steps;
}

void bareMujoco(State& state) {
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(&scene()->model()), mj_deleteData);
  for ([[maybe_unused]] auto _ : state) {
    for (const pusht::Trace& trace : referenceTraces()) {
      sim2sim::stepBareMujoco(scene()->model(), *data, trace);
    }
  }
  state.SetItemsProcessed(state.iterations() * stepsOf(referenceTraces()));
}
BENCHMARK(bareMujoco)->Name("mujoco/bare");

void mujocoWorld(State& state) {
  pusht::MujocoWorld world(scene());
  for ([[maybe_unused]] auto _ : state) {
    for (const pusht::Trace& trace : referenceTraces()) {
      world.reset(trace.states.front());
      for (const pusht::Action& action : trace.actions) {
        world.step(action);
      }
    }
  }
  state.SetItemsProcessed(state.iterations() * stepsOf(referenceTraces()));
}
BENCHMARK(mujocoWorld)->Name("mujoco/world");

// ---- The same actions in the engine that follows MuJoCo

void faithfulEngine(State& state) {
  pusht::RigidBodyEngine engine;
  for ([[maybe_unused]] auto _ : state) {
    for (const pusht::Trace& trace : referenceTraces()) {
      engine.reset(trace.states.front());
      for (const pusht::Action& action : trace.actions) {
        engine.step(action);
      }
    }
  }
  state.SetItemsProcessed(state.iterations() * stepsOf(referenceTraces()));
}
BENCHMARK(faithfulEngine)->Name("faithful/world");

// ---- The same actions in every kind that is installed, with its defaults

void kindSteps(State& state, const pusht::SimulatorKind& kind) {
  const auto world = kind.load(kind.defaults()).make_world();
  for ([[maybe_unused]] auto _ : state) {
    for (const pusht::Trace& trace : referenceTraces()) {
      world->reset(trace.states.front());
      for (const pusht::Action& action : trace.actions) {
        world->step(action);
      }
    }
  }
  state.SetItemsProcessed(state.iterations() * stepsOf(referenceTraces()));
}

void kindResets(State& state, const pusht::SimulatorKind& kind) {
  const auto world = kind.load(kind.defaults()).make_world();
  for ([[maybe_unused]] auto _ : state) {
    for (const pusht::Trace& trace : referenceTraces()) {
      world->reset(trace.states.front());
    }
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(referenceTraces().size()));
}

void registerKinds() {
  const auto& kinds = pusht::SimulatorKinds::installed();
  for (const std::string& name : kinds.names()) {
    const pusht::SimulatorKind& kind = kinds.named(name);
    benchmark::RegisterBenchmark(("kind/" + name).c_str(), [&kind](State& state) { kindSteps(state, kind); });
    benchmark::RegisterBenchmark(("reset/" + name).c_str(), [&kind](State& state) { kindResets(state, kind); });
  }
}

// ---- Policy

void policyRows(State& state, pusht::NetworkPolicy& policy) {
  std::vector<pusht::Policy::Query> queries(state.range(0));
  for (std::size_t i = 0; i < queries.size(); ++i) {
    queries[i] = {pusht::observe(pusht::spawn(i)), nullptr};
  }
  std::vector<pusht::Action> actions(queries.size());
  for ([[maybe_unused]] auto _ : state) {
    policy.act(queries, actions);
    benchmark::DoNotOptimize(actions.data());
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

void kernelRows(State& state, pusht::InstructionSet instruction_set) {
  const auto available = pusht::availableInstructionSets();
  if (std::find(available.begin(), available.end(), instruction_set) == available.end()) {
    return state.SkipWithError("not on this processor");
  }
  policyRows(state, *pusht::NetworkPolicy::load(shippedPolicy(), instruction_set));
}
constexpr int kBatch = 2 * sim2sim::kEpisodesInFlight;  // rows
BENCHMARK_CAPTURE(kernelRows, baseline, pusht::InstructionSet::kBaseline)->Name("policy/baseline")->Arg(1)->Arg(kBatch);
BENCHMARK_CAPTURE(kernelRows, avx2, pusht::InstructionSet::kAvx2)->Name("policy/AVX2")->Arg(1)->Arg(kBatch);
BENCHMARK_CAPTURE(kernelRows, avx512, pusht::InstructionSet::kAvx512)->Name("policy/AVX-512")->Arg(1)->Arg(kBatch);

void libtorchRows(State& state) { policyRows(state, *pusht::NetworkPolicy::loadOnLibtorch(shippedPolicy())); }
BENCHMARK(libtorchRows)->Name("policy/libtorch")->Arg(1);

// ---- Bag and service

void bagWrite(State& state) {
  const pusht::testing::TemporaryFolder folder;
  pusht::BagFile bag(folder / "messages.bag");
  pusht_msgs::Divergence message;
  ros::Time stamp(1.0);
  for ([[maybe_unused]] auto _ : state) {
    stamp += ros::Duration(pusht::kControlStep);
    message.header.stamp = stamp;
    bag.write("/sim2sim/divergence", stamp, message);
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(bagWrite)->Name("bag/write");

/// Round trip of the engine's smallest service; its node must run.
void serviceRoundTrip(State& state) {
  if (!ros::master::check()) {
    return state.SkipWithError("no master");
  }
  ros::NodeHandle node;
  auto client = node.serviceClient<pusht_msgs::Describe>("/engine/describe", true);
  pusht_msgs::Describe describe;
  for ([[maybe_unused]] auto _ : state) {
    if (!client.call(describe)) {
      return state.SkipWithError("no answer from /engine/describe");
    }
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(serviceRoundTrip)->Name("service/round_trip")->UseRealTime();

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "pieces", ros::init_options::AnonymousName | ros::init_options::NoSigintHandler);
  registerKinds();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return static_cast<int>(pusht::ExitCode::kInvalidInput);
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
