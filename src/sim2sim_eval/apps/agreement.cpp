// SPDX-License-Identifier: BSD-3-Clause
#include "batch/agreement.hpp"

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  sim2sim::AgreementOptions options;
  return sim2sim::runCommand(
      "agreement",
      "Says how far all pairs of simulators part when they replay the same actions from the same states, and which one "
      "is in the middle.",
      argc, argv, [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::agreement(options); });
}
