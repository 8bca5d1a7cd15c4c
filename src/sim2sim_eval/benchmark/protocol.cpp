// SPDX-License-Identifier: BSD-3-Clause
// Times the whole protocol beside the bare mj_step calls that it contains, in turn, on the same episodes, and what
// threads, a kept reference and our policy kernel change.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bare_mujoco.hpp"
#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_policy/network_policy.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/temporary_folder.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/loaded_run.hpp"
#include "sim2sim_protocol/reference_cache.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/provenance.hpp"
#include "sim2sim_protocol/runner.hpp"
#include "sim2sim_serving/installed_file.hpp"

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
  std::vector<pusht::Trace> traces(protocol.episodes);
  for (int episode = 0; episode < protocol.episodes; ++episode) {
    traces[episode] = pusht::runClosedLoop(world, protocol.initialState(episode), policy, protocol.horizon).trace();
  }
  return traces;
}

void benchmark(const sim2sim::Protocol& protocol, int repetitions) {
  protocol.validate();
  const auto scene = std::make_shared<const pusht::MujocoScene>();
  const auto shipped = pusht::installedFile("pusht_policy", pusht::kShippedCheckpoint);
  const auto policy = pusht::NetworkPolicy::load(shipped);
  const auto on_libtorch = pusht::NetworkPolicy::loadOnLibtorch(shipped);
  const std::vector<pusht::Trace> traces = referenceTraces(protocol, scene, *policy);
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(&scene->model()), mj_deleteData);

  const sim2sim::SimulatorChoice chosen = sim2sim::chooseSimulator("two_mass", {});
  const sim2sim::LoadedRun loaded(pusht::PolicyChoice(), sim2sim::chooseSimulator("mujoco", {}), {chosen}, {});
  const sim2sim::LoadedSimulator engine(chosen);
  const sim2sim::LoadedSimulator with_other_parameter(sim2sim::chooseSimulator("two_mass", {"block_damp=20"}));
  sim2sim::WorkerFactory with_libtorch = loaded.workerFactory(engine);
  with_libtorch.make_policy = [&] { return on_libtorch->clone(); };
  const pusht::testing::TemporaryFolder folder;
  const sim2sim::ReferenceCache references(folder.path(), loaded.referenceKey(protocol));
  const auto run = [&](const sim2sim::WorkerFactory& factory, int threads, const sim2sim::ReferenceCache* cache) {
    sim2sim::runProtocol(
        protocol, factory, threads, cache, [](const sim2sim::Episode&) {}, [] { return false; });
  };
  run(loaded.workerFactory(engine), 1, &references);  // from here on the reference is kept

  const std::map<std::string, std::function<void()>> works = {
      {"bare_mj_step",
       [&] {
         for (const pusht::Trace& trace : traces) {
           sim2sim::stepBareMujoco(scene->model(), *data, trace);
         }
       }},
      {"one_thread", [&] { run(loaded.workerFactory(engine), 1, nullptr); }},
      {"two_threads", [&] { run(loaded.workerFactory(engine), 2, nullptr); }},
      {"further_parameter_value", [&] { run(loaded.workerFactory(with_other_parameter), 1, &references); }},
      {"libtorch", [&] { run(with_libtorch, 1, nullptr); }},
  };
  std::map<std::string, std::vector<double>> seconds;
  for (int i = 0; i < repetitions; ++i) {
    for (const auto& [name, work] : works) {
      seconds[name].push_back(timed(work));
    }
  }
  const auto ratio = [&](const char* a, const char* b) {  // of what was timed one after the other
    std::vector<double> ratios(repetitions);
    std::transform(seconds[a].begin(), seconds[a].end(), seconds[b].begin(), ratios.begin(), std::divides<>());
    return median(ratios);
  };

  nlohmann::json result = {{"episodes", protocol.episodes},
                           {"repetitions", repetitions},
                           {"software", sim2sim::buildAndMachine()},
                           {"mujoco", loaded.reference().kind.version},
                           {"blas", policy->info().blas},
                           {"instruction_set", policy->info().instruction_set},
                           {"ratios",
                            {{"protocol_over_bare_mj_step", ratio("one_thread", "bare_mj_step")},
                             {"one_thread_over_two", ratio("one_thread", "two_threads")},
                             {"further_parameter_value_over_first", ratio("further_parameter_value", "one_thread")},
                             {"libtorch_over_kernel", ratio("libtorch", "one_thread")}}}};
  for (const auto& [name, samples] : seconds) {
    result["seconds"][name] = median(samples);
  }
  std::size_t steps = 0;
  for (const pusht::Trace& trace : traces) {
    steps += trace.steps();
  }
  result["reference_control_steps"] = steps;
  std::cout << sim2sim::jsonText(result);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Times the protocol with the shipped policy beside the bare mj_step calls that it contains; prints JSON.",
      "benchmark_protocol");
  sim2sim::Protocol protocol;
  protocol.floor = false;  // as the bare calls have none
  int repetitions = 7;
  app.add_option("--episodes", protocol.episodes, "number of episodes")
      ->check(sim2sim::decimalInteger())
      ->capture_default_str();
  app.add_option("--repetitions", repetitions, "timed runs of each")->check(CLI::PositiveNumber)->capture_default_str();
  return sim2sim::runCommand(app, argc, argv, [&] { benchmark(protocol, repetitions); });
}
