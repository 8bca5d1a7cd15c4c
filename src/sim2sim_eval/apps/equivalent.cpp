// SPDX-License-Identifier: BSD-3-Clause
#include "batch/equivalent.hpp"

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  sim2sim::EquivalentOptions options;
  return sim2sim::runCommand(
      "equivalent",
      "Says how large an error of the reference, or of the loop between policy and reference, costs as much success as "
      "changing to the engine does: a delay, noise, a mass. Reads a sweep over engines and errors, such as "
      "config/equivalent.yaml. Writes equivalent.json and equivalent.csv into its folder.",
      argc, argv, [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::equivalent(options); });
}
