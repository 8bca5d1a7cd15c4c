// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/attribute.hpp"

#include <CLI/CLI.hpp>

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  CLI::App app(
      "Says how much of the gap each switch of the engine explains, from a sweep over all combinations of true/false "
      "parameters. Writes attribution.json and attribution.csv into its folder.",
      "attribute");
  sim2sim::AttributeOptions options;
  options.declare(app);
  return sim2sim::runCommand(app, argc, argv, [&] { sim2sim::attribute(options); });
}
