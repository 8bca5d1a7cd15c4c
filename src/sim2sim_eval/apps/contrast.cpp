// SPDX-License-Identifier: BSD-3-Clause
#include "batch/contrast.hpp"

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  sim2sim::ContrastOptions options;
  return sim2sim::runCommand(
      "contrast", "Compares runs over the same episodes pair by pair: two folders of results, or the rows of a sweep.",
      argc, argv, [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::contrast(options); });
}
