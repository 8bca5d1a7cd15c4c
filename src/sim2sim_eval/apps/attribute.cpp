// SPDX-License-Identifier: BSD-3-Clause
// Says what causes the gap between two simulators.
#include <filesystem>
#include <iostream>
#include <string>

#include "pusht_task/files.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_eval/results/attribution.hpp"
#include "sim2sim_eval/results/output_folder.hpp"
#include "sim2sim_eval/results/report.hpp"

namespace {

void attribute(const std::filesystem::path& sweep, const std::filesystem::path& baseline) {
  const auto go_on = [] { sim2sim::requireNotInterrupted(); };
  const sim2sim::Attribution attribution = sim2sim::attribute(sweep, baseline, go_on);
  go_on();
  std::cout << sim2sim::table(attribution);
  pusht::writeFile(sweep / sim2sim::kAttributionTable, sim2sim::toCsv(attribution));
  pusht::writeFile(sweep / sim2sim::kAttributionFile, sim2sim::jsonText(sim2sim::toJson(attribution)));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Says how much of the gap each switch of the engine explains, from a sweep over all combinations of true/false "
      "parameters. Writes attribution.json and attribution.csv into its folder.",
      "attribute");
  std::string sweep;
  std::string baseline;
  app.add_option("sweep", sweep, "folder of the sweep")->required();
  app.add_option("--baseline", baseline, "folder of a run over the same episodes, to be shown beside");
  return sim2sim::runCommand(app, argc, argv, [&] { attribute(sweep, baseline); });
}
