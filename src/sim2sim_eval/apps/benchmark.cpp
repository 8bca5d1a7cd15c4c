// SPDX-License-Identifier: BSD-3-Clause
// Times the whole protocol beside the bare mj_step calls that it contains, in turn, on the same episodes.
#include <algorithm>
#include <chrono>
#include <functional>
#include <iostream>
#include <memory>
#include <vector>

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_policy/network_policy.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/ros/installed_file.hpp"
#include "pusht_task/spawn.hpp"
#include "sim2sim_eval/command_line.hpp"
#include "sim2sim_eval/protocol.hpp"
#include "sim2sim_eval/setup.hpp"

namespace {

using Scene = std::shared_ptr<const pusht::MujocoScene>;

/// [s] of wall-clock time that `work` takes.
double timed(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> samples) {
  std::nth_element(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2), samples.end());
  return samples[samples.size() / 2];
}

/// The reference rollouts of the protocol: what bare MuJoCo is then made to repeat.
std::vector<pusht::Trace> referenceTraces(const sim2sim::Protocol& protocol, const Scene& scene,
                                          pusht::Policy& policy) {
  pusht::MujocoWorld world(scene);
  std::vector<pusht::Trace> traces;
  for (int episode = 0; episode < protocol.episodes; ++episode) {
    traces.push_back(
        pusht::runClosedLoop(world, pusht::spawn(protocol.spawnSeed(episode)), policy, protocol.horizon).trace());
  }
  return traces;
}

/// Nothing but MuJoCo's own calls.
void stepBare(const mjModel* model, mjData* data, const pusht::Trace& trace) {
  const pusht::WorldState& start = trace.states.front();
  mj_resetData(model, data);
  data->qpos[0] = start.tee_position.x();
  data->qpos[1] = start.tee_position.y();
  data->qpos[2] = start.tee_yaw;
  data->qpos[3] = start.pusher_position.x();
  data->qpos[4] = start.pusher_position.y();
  mj_forward(model, data);
  for (const pusht::Action& action : trace.actions) {
    data->ctrl[0] = action[0];
    data->ctrl[1] = action[1];
    for (int i = 0; i < pusht::kSubstepsPerControlStep; ++i) {
      mj_step(model, data);
    }
  }
}

void benchmark(const sim2sim::Protocol& protocol, int repetitions) {
  protocol.validate();
  const auto scene =
      std::make_shared<const pusht::MujocoScene>(pusht::installedFile("pusht_mujoco", "scenes/pusht.xml"));
  const auto policy = pusht::NetworkPolicy::load(pusht::installedFile("pusht_policy", "policies/bc_policy.ts.pt"));
  const std::vector<pusht::Trace> traces = referenceTraces(protocol, scene, *policy);
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(&scene->model()), mj_deleteData);
  const sim2sim::Players players = sim2sim::Setup({}, "").players({});

  std::vector<double> bare;
  std::vector<double> whole;
  std::vector<double> ratios;
  for (int i = 0; i < repetitions; ++i) {
    bare.push_back(timed([&] {
      for (const pusht::Trace& trace : traces) {
        stepBare(&scene->model(), data.get(), trace);
      }
    }));
    whole.push_back(timed([&] {
      sim2sim::runProtocol(
          protocol, players, 1, nullptr, [](const sim2sim::Episode&) {}, [] { return false; });
    }));
    ratios.push_back(whole.back() / bare.back());
  }

  std::size_t steps = 0;
  for (const pusht::Trace& trace : traces) {
    steps += trace.steps();
  }
  std::cout << protocol.episodes << " episodes, " << steps << " control steps of the reference, one thread, median of "
            << repetitions << " runs in turn\n"
            << "bare mj_step      " << pusht::fixedText(median(bare), 3) << " s\n"
            << "whole protocol    " << pusht::fixedText(median(whole), 3) << " s\n"
            << "ratio             " << pusht::fixedText(median(ratios), 2) << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Times the protocol with the shipped policy beside the bare mj_step calls that it contains.",
               "benchmark");
  sim2sim::Protocol protocol;
  int repetitions = 7;
  app.add_option("--episodes", protocol.episodes, "number of episodes")->capture_default_str();
  app.add_option("--repetitions", repetitions, "timed runs of each")->check(CLI::PositiveNumber)->capture_default_str();
  return sim2sim::runCommand(app, argc, argv, [&] { benchmark(protocol, repetitions); });
}
