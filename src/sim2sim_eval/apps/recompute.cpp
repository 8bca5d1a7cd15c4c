// SPDX-License-Identifier: BSD-3-Clause
#include "batch/recompute.hpp"

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  sim2sim::RecomputeOptions options;
  return sim2sim::runCommand(
      "recompute", "Computes the results of a run again from its bag; they are the same, byte for byte.", argc, argv,
      [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::recompute(options); });
}
