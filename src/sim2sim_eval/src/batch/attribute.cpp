// SPDX-License-Identifier: BSD-3-Clause
#include "batch/attribute.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "batch/derived_files.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/attribution.hpp"
#include "sim2sim_protocol/results/attribution_files.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {
void AttributeOptions::declare(CLI::App& app) {
  app.add_option("sweep", sweep, "folder of the sweep")->required()->check(notEmpty());
  app.add_option("--baseline", baseline, "folder of a run over the same episodes, to be shown beside")
      ->check(notEmpty());
  app.add_flag("--overwrite", overwrite, "replace an attribution that is in the folder already");
}

void attribute(const AttributeOptions& options) {
  const DerivedFiles files("attribution", options.sweep, kAttributionFile, kAttributionTable, options.overwrite);
  const auto go_on = [] { requireNotInterrupted(); };
  const Attribution attribution = attribute(options.sweep, options.baseline, go_on);
  go_on();
  std::cout << table(attribution);
  files.write(toJson(attribution), toCsv(attribution));
}

}  // namespace sim2sim
