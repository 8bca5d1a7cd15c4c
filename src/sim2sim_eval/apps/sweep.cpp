// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/sweep.hpp"

#include <CLI/CLI.hpp>

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  CLI::App app("Runs the comparison for many settings of the engine's parameters, over the same episodes.", "sweep");
  sim2sim::SweepOptions options;
  options.declare(app);
  return sim2sim::runCommand(app, argc, argv, [&] { sim2sim::sweep(options); });
}
