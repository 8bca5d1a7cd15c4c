// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/comparison.hpp"

int main(int argc, char** argv) {
  sim2sim::CompareOptions options;
  return sim2sim::runCommand(
      "compare", "Runs one policy from the same starts in two simulators, and measures the gap.", argc, argv,
      [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::compare(options); });
}
