// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/contrast.hpp"

#include <CLI/CLI.hpp>

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  CLI::App app("Compares runs over the same episodes pair by pair: two folders of results, or the rows of a sweep.",
               "contrast");
  sim2sim::ContrastOptions options;
  options.declare(app);
  return sim2sim::runCommand(app, argc, argv, [&] { sim2sim::contrast(options); });
}
