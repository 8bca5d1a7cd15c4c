// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "batch/derived_files.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/equivalent_files.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {

/// Prints the equivalents of each engine of a sweep, and writes equivalent.json and equivalent.csv into its folder.
int equivalentMain(int argc, char** argv) {
  std::string sweep;
  bool overwrite = false;
  CLI::App app(
      "Says how large an error of the reference, or of the loop between policy and reference, costs as much success as "
      "changing to the engine does: a delay, noise, a mass. Reads a sweep over engines and errors, such as "
      "config/equivalent.yaml. Writes equivalent.json and equivalent.csv into its folder.",
      "equivalent");
  app.add_option("sweep", sweep, "folder of the sweep: engines, and the reference's kind with errors of several sizes")
      ->required()
      ->check(notEmpty());
  app.add_flag("--overwrite", overwrite, "replace equivalents that are in the folder already");
  return runCommand(app, argc, argv, [&] {
    const DerivedFiles files("equivalents", sweep, kEquivalentFile, kEquivalentTable, overwrite);
    const auto go_on = [] { requireNotInterrupted(); };
    const Equivalents equivalents = readEquivalents(sweep, go_on);
    go_on();
    std::cout << table(equivalents);
    files.write(toJson(equivalents), toCsv(equivalents));
  });
}

}  // namespace sim2sim
