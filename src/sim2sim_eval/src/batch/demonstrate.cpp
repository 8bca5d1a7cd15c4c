// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/demonstrate.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "pusht_policy/scripted_expert.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/provenance.hpp"

namespace sim2sim {

void DemonstrateOptions::declare(CLI::App& app) {
  app.add_option("--seed", plan.seed, "spawn seed of the first demonstration")->check(decimalInteger());
  app.add_option("--episodes", plan.episodes, "number of demonstrations")->check(decimalInteger());
  app.add_option("--out", out, "the bag to write")->check(notEmpty());
}

void demonstrate(const DemonstrateOptions& options) {
  const LoadedSimulator mujoco(chooseSimulator("mujoco", {}));
  const auto world = mujoco.model.make_world();
  pusht::ScriptedExpert expert;
  ProgressBar bar("demonstrations", options.plan.episodes);
  nlohmann::json software = buildAndMachine();
  software["mujoco"] = mujoco.kind.version;
  const nlohmann::json origin = {{"demonstrator", "scripted expert"},
                                 {"simulator", mujoco.kind.name},
                                 {"scene", mujoco.model.provenance.at("scene").at("sha256")},
                                 {"software", software}};
  const pusht::DemonstrationTally tally =
      pusht::recordDemonstrations(options.plan, *world, expert, origin, options.out, [&](const auto& so_far) {
        bar.advance(std::to_string(so_far.successes) + " solved");
        return !interrupted();
      });
  std::cout << tally.episodes << " demonstrations, " << tally.successes << " solved, " << tally.frames
            << " frames: " << options.out << std::endl;
}

}  // namespace sim2sim
