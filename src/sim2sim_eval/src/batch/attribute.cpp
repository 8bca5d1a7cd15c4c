// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "batch/derived_files.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/attribution.hpp"
#include "sim2sim_protocol/results/attribution_files.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {

/// Prints the attribution of a sweep, and writes attribution.json and attribution.csv into its folder: both, or none.
int attributeMain(int argc, char** argv) {
  std::filesystem::path sweep;
  std::filesystem::path baseline;
  bool overwrite = false;
  CLI::App app(
      "Says how much of the gap each switch of the engine explains, from a sweep over all combinations of true/false "
      "parameters. Writes attribution.json and attribution.csv into its folder.",
      "attribute");
  app.add_option("sweep", sweep, "folder of the sweep")->required()->check(notEmpty());
  app.add_option("--baseline", baseline, "folder of a run over the same episodes, to be shown beside")
      ->check(notEmpty());
  app.add_flag("--overwrite", overwrite, "replace an attribution that is in the folder already");
  return runCommand(app, argc, argv, [&] {
    const DerivedFiles files("attribution", sweep, kAttributionFile, kAttributionTable, overwrite);
    const auto go_on = [] { requireNotInterrupted(); };
    const Attribution attribution = readAttribution(sweep, baseline, go_on);
    go_on();
    std::cout << table(attribution);
    files.write(toJson(attribution), toCsv(attribution));
  });
}

}  // namespace sim2sim
