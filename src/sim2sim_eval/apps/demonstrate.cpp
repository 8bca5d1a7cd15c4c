// SPDX-License-Identifier: BSD-3-Clause
// Records demonstrations of the scripted expert in the reference simulator.
#include <CLI/CLI.hpp>
#include <iostream>
#include <string>

#include "pusht_policy/demonstrations.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/provenance.hpp"

namespace {

void demonstrate(const pusht::DemonstrationPlan& plan, const std::string& out) {
  const sim2sim::LoadedSimulator mujoco(sim2sim::chooseSimulator("mujoco", {}));
  const auto world = mujoco.model.make_world();
  pusht::ScriptedExpert expert;
  sim2sim::ProgressBar bar("demonstrations", plan.episodes);
  nlohmann::json software = sim2sim::buildAndMachine();
  software["mujoco"] = mujoco.kind.version;
  const nlohmann::json origin = {{"demonstrator", "scripted expert"},
                                 {"simulator", mujoco.kind.name},
                                 {"scene", mujoco.model.provenance.at("scene").at("sha256")},
                                 {"software", software}};
  const auto tally = pusht::recordDemonstrations(plan, *world, expert, origin, out, [&](const auto& so_far) {
    bar.advance(std::to_string(so_far.successes) + " solved");
    return !sim2sim::interrupted();
  });
  std::cout << tally.episodes << " demonstrations, " << tally.successes << " solved, " << tally.frames
            << " frames: " << out << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Records demonstrations of the scripted expert in MuJoCo as a rosbag.", "demonstrate");
  pusht::DemonstrationPlan plan;
  std::string out = "demonstrations.bag";
  app.add_option("--seed", plan.seed, "spawn seed of the first demonstration")->check(sim2sim::decimalInteger());
  app.add_option("--episodes", plan.episodes, "number of demonstrations")->check(sim2sim::decimalInteger());
  app.add_option("--out", out, "the bag to write")->check(sim2sim::notEmpty());
  return sim2sim::runCommand(app, argc, argv, [&] { demonstrate(plan, out); });
}
