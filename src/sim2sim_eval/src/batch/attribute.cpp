// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/attribute.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/attribution.hpp"
#include "sim2sim_protocol/results/attribution_files.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;

void requireNoAttribution(const fs::path& path) {
  std::error_code ignored;
  if (fs::symlink_status(path, ignored).type() != fs::file_type::not_found) {
    throw pusht::InvalidInput("attribution " + path.string() + ": is there already; replace it with --overwrite");
  }
}

}  // namespace

void AttributeOptions::declare(CLI::App& app) {
  app.add_option("sweep", sweep, "folder of the sweep")->required()->check(notEmpty());
  app.add_option("--baseline", baseline, "folder of a run over the same episodes, to be shown beside")
      ->check(notEmpty());
  app.add_flag("--overwrite", overwrite, "replace an attribution that is in the folder already");
}

void attribute(const AttributeOptions& options) {
  const fs::path csv = options.sweep / kAttributionTable;
  const fs::path json = options.sweep / kAttributionFile;
  if (!options.overwrite) {
    requireNoAttribution(csv);
    requireNoAttribution(json);
  }
  const auto go_on = [] { requireNotInterrupted(); };
  const Attribution attribution = attribute(options.sweep, options.baseline, go_on);
  go_on();
  std::cout << table(attribution);
  pusht::AsideFile new_csv(csv);  // both files, or none
  pusht::AsideFile new_json(json);
  new_csv.write(toCsv(attribution), true);
  new_json.write(jsonText(toJson(attribution)), true);
  new_csv.moveIntoPlace();
  new_json.moveIntoPlace();
}

}  // namespace sim2sim
