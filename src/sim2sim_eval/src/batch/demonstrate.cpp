// SPDX-License-Identifier: BSD-3-Clause
#include "batch/demonstrate.hpp"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <iostream>
#include <nlohmann/json.hpp>

#include "batch/demonstration_simulators.hpp"
#include "pusht_task/joined.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/provenance.hpp"
#include "sim2sim_serving/simulator_kinds.hpp"

namespace sim2sim {

int demonstrateMain(int argc, char** argv) {
  DemonstrateOptions options;
  pusht::DemonstrationPlan& plan = options.plan;
  CLI::App app("Records demonstrations of an expert as a rosbag.", "demonstrate");
  app.add_option("--task", options.task, "what is demonstrated: full_circle, gym_pusht, or a file NAME.json")
      ->capture_default_str();
  app.add_option("--demonstrator", options.demonstrator, "expert, the scripted one; or planner")
      ->check(CLI::IsMember({pusht::kExpertPolicy, pusht::kPlannerPolicy}))
      ->capture_default_str();
  app.add_option("--seed", plan.seed, "spawn seed of the first demonstration")->check(decimalInteger());
  app.add_option("--episodes", plan.episodes, "number of demonstrations")->check(decimalInteger());
  app.add_option("--simulator", options.simulators,
                 "kind of simulator: " + pusht::joined(pusht::SimulatorKinds::installed().names()) +
                     "; with parameters: KIND:NAME=VALUE:NAME=VALUE; may be repeated: simulators take turns")
      ->allow_extra_args(false)
      ->capture_default_str();
  app.add_option("--set,--draw", options.settings,
                 "NAME=VALUE: a parameter of the simulator, or NAME=LEAST..GREATEST, as in friction=0.5..1.5: one that "
                 "is drawn for each demonstration; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--action-noise", plan.action_noise,
                 "standard deviation of the noise on each axis of the actions that the world takes [m/s, or the task's "
                 "unit]; the bag has the actions without it")
      ->check(decimalReal())
      ->capture_default_str();
  app.add_option("--out", options.out, "the bag to write")->check(notEmpty());
  return runCommand(app, argc, argv, [&] { demonstrate(options); });
}

void demonstrate(const DemonstrateOptions& options) {
  pusht::DemonstrationPlan plan = options.plan;
  plan.task = pusht::taskNamed(options.task);
  plan.validate();
  DemonstrationSimulators simulators(options.simulators, options.settings, plan.task);
  const std::unique_ptr<pusht::Policy> demonstrator =
      pusht::choosePolicy({options.demonstrator, true, 0, false, plan.task}, {}).make();
  const bool is_scripted = options.demonstrator == pusht::kExpertPolicy;
  ProgressBar bar("demonstrations", plan.episodes);
  const nlohmann::json origin = {{"demonstrator", is_scripted ? "scripted expert" : "planning expert"},
                                 {"simulators", simulators.description()},
                                 {"software", buildAndMachine()}};
  const pusht::DemonstrationTally tally = pusht::recordDemonstrations(
      plan, [&](std::uint64_t seed) { return simulators.worldOf(seed); }, *demonstrator, origin, options.out,
      [&](const auto& so_far) {
        bar.advance(std::to_string(so_far.successes) + " solved");
        return !interrupted();
      });
  bar.clear();
  std::cout << tally.episodes << " demonstrations, " << tally.successes << " solved, " << tally.frames
            << " frames: " << options.out << std::endl;
}

}  // namespace sim2sim
