// SPDX-License-Identifier: BSD-3-Clause
/// A recorded run as a node, in place of the evaluator.
#include "live/serve_playback.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_serving/node.hpp"

int main(int argc, char** argv) {
  sim2sim::catchInterruptsAside("sim2sim");
  return pusht::runNode(argc, argv, "sim2sim", pusht::NoMaster::kFail, sim2sim::servePlayback, pusht::Life::kRunsOnce);
}
