// SPDX-License-Identifier: BSD-3-Clause
#include "batch/matrix.hpp"

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  sim2sim::MatrixOptions options;
  return sim2sim::runCommand(
      "matrix",
      "Says how each policy of a sweep does in each simulator, what it keeps of its success in its reference, and what "
      "holds for groups of policies. Writes matrix.json and matrix.csv into the folder of the sweep.",
      argc, argv, [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::matrix(options); });
}
