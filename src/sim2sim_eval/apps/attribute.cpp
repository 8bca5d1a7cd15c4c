// SPDX-License-Identifier: BSD-3-Clause
// Says what causes the gap between two simulators.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/attribution.hpp"
#include "sim2sim_protocol/results/attribution_files.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/output_folder.hpp"

namespace {

namespace fs = std::filesystem;

void attribute(const fs::path& sweep, const fs::path& baseline, bool overwrite) {
  const fs::path table = sweep / sim2sim::kAttributionTable;
  const fs::path file = sweep / sim2sim::kAttributionFile;
  for (const fs::path& path : {table, file}) {
    std::error_code ignored;
    if (!overwrite && fs::symlink_status(path, ignored).type() != fs::file_type::not_found) {
      throw pusht::InvalidInput("attribution " + path.string() + ": is there already; replace it with --overwrite");
    }
  }
  const auto go_on = [] { sim2sim::requireNotInterrupted(); };
  const sim2sim::Attribution attribution = sim2sim::attribute(sweep, baseline, go_on);
  go_on();
  std::cout << sim2sim::table(attribution);
  pusht::AsideFile new_table(table);  // both files, or none
  pusht::AsideFile new_file(file);
  new_table.write(sim2sim::toCsv(attribution), true);
  new_file.write(sim2sim::jsonText(sim2sim::toJson(attribution)), true);
  new_table.moveIntoPlace();
  new_file.moveIntoPlace();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Says how much of the gap each switch of the engine explains, from a sweep over all combinations of true/false "
      "parameters. Writes attribution.json and attribution.csv into its folder.",
      "attribute");
  std::string sweep;
  std::string baseline;
  app.add_option("sweep", sweep, "folder of the sweep")->required()->check(sim2sim::notEmpty());
  app.add_option("--baseline", baseline, "folder of a run over the same episodes, to be shown beside")
      ->check(sim2sim::notEmpty());
  bool overwrite = false;
  app.add_flag("--overwrite", overwrite, "replace an attribution that is in the folder already");
  return sim2sim::runCommand(app, argc, argv, [&] { attribute(sweep, baseline, overwrite); });
}
