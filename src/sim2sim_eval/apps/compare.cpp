// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/comparison.hpp"

int main(int argc, char** argv) {
  CLI::App app("Runs one policy from the same starts in two simulators, and measures the gap.", "compare");
  sim2sim::CompareOptions options;
  options.declare(app);
  return sim2sim::runCommand(app, argc, argv, [&] { sim2sim::compare(options); });
}
