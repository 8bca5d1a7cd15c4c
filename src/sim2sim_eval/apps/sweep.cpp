// SPDX-License-Identifier: BSD-3-Clause
#include "batch/sweep.hpp"

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  sim2sim::SweepOptions options;
  return sim2sim::runCommand(
      "sweep", "Runs the comparison for many settings of the engine's parameters, over the same episodes.", argc, argv,
      [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::sweep(options); });
}
