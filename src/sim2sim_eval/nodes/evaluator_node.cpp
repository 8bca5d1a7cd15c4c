// SPDX-License-Identifier: BSD-3-Clause
/// The evaluator as a node.
#include "live/evaluate.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_serving/node.hpp"

int main(int argc, char** argv) {
  sim2sim::catchInterruptsAside("sim2sim");  // before all else, so that status.json tells of any
  return pusht::runNode(argc, argv, "sim2sim", pusht::NoMaster::kFail, sim2sim::evaluate, pusht::Life::kRunsOnce);
}
