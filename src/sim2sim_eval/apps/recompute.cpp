// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/recompute.hpp"

#include <CLI/CLI.hpp>

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  CLI::App app("Computes the results of a run again from its bag; they are the same, byte for byte.", "recompute");
  sim2sim::RecomputeOptions options;
  options.declare(app);
  return sim2sim::runCommand(app, argc, argv, [&] { sim2sim::recompute(options); });
}
