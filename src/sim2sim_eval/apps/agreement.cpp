// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/agreement.hpp"

#include <CLI/CLI.hpp>

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  CLI::App app(
      "Says how far all pairs of simulators part when they replay the same actions from the same states, and which one "
      "is in the middle.",
      "agreement");
  sim2sim::AgreementOptions options;
  options.declare(app);
  return sim2sim::runCommand(app, argc, argv, [&] { sim2sim::agreement(options); });
}
