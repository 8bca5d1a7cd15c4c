// SPDX-License-Identifier: BSD-3-Clause
#include "batch/equivalent.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>

#include "batch/derived_files.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/equivalent_files.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {
void EquivalentOptions::declare(CLI::App& app) {
  app.add_option("sweep", sweep, "folder of the sweep: engines, and the reference's kind with errors of several sizes")
      ->required()
      ->check(notEmpty());
  app.add_flag("--overwrite", overwrite, "replace equivalents that are in the folder already");
}

void equivalent(const EquivalentOptions& options) {
  const DerivedFiles files("equivalents", options.sweep, kEquivalentFile, kEquivalentTable, options.overwrite);
  const auto go_on = [] { requireNotInterrupted(); };
  const Equivalents equivalents = readEquivalents(options.sweep, go_on);
  go_on();
  std::cout << table(equivalents);
  files.write(toJson(equivalents), toCsv(equivalents));
}

}  // namespace sim2sim
