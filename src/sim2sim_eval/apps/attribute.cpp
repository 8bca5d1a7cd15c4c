// SPDX-License-Identifier: BSD-3-Clause
#include "batch/attribute.hpp"

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  sim2sim::AttributeOptions options;
  return sim2sim::runCommand(
      "attribute",
      "Says how much of the gap each switch of the engine explains, from a sweep over all combinations of true/false "
      "parameters. Writes attribution.json and attribution.csv into its folder.",
      argc, argv, [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::attribute(options); });
}
