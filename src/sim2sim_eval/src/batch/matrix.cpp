// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batch/derived_files.hpp"
#include "batch/hypotheses_file.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/hypotheses_files.hpp"
#include "sim2sim_protocol/results/matrix_files.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {

/// Prints the matrix of a sweep, and writes matrix.json and matrix.csv into its folder: both, or none.
int matrixMain(int argc, char** argv) {
  std::filesystem::path sweep;
  std::vector<std::string> groups;
  std::vector<std::string> policies;
  std::filesystem::path hypotheses;
  bool overwrite = false;
  CLI::App app(
      "Says how each policy of a sweep does in each simulator, what it keeps of its success in its reference, and what "
      "holds for groups of policies. Writes matrix.json and matrix.csv into the folder of the sweep.",
      "matrix");
  app.add_option("sweep", sweep, "folder of the sweep, from a plan that lists policies")->required()->check(notEmpty());
  app.add_option("--group", groups, "only the policies of this group of the plan; may be repeated")
      ->type_size(1)
      ->allow_extra_args(false)
      ->check(notEmpty());
  app.add_option("--pair", policies, "two policies or more, each of which is compared with the others start by start")
      ->check(notEmpty());
  app.add_option("--hypotheses", hypotheses,
                 "YAML file with differences between groups of policies that were expected before the sweep was run; "
                 "each is tested")
      ->check(notEmpty());
  app.add_flag("--overwrite", overwrite, "replace a matrix that is in the folder already");
  return runCommand(app, argc, argv, [&] {
    const DerivedFiles files("matrix", sweep, kMatrixFile, kMatrixTable, overwrite);
    const std::vector<Hypothesis> expected =
        hypotheses.empty() ? std::vector<Hypothesis>() : readHypotheses(hypotheses);
    const Matrix matrix = readMatrix(sweep, groups, [] { requireNotInterrupted(); });
    const std::vector<HypothesisResult> tested = test(matrix, expected);
    const std::vector<PolicyPair> pairs = pairsOf(matrix, policies);
    requireNotInterrupted();
    std::cout << table(matrix) << table(matrix, pairs) << table(tested);
    nlohmann::json content = toJson(matrix);
    content["hypotheses"] = toJson(tested);
    if (!pairs.empty()) {
      content["pairs"] = toJson(matrix, pairs);
    }
    files.write(content, toCsv(matrix));
  });
}

}  // namespace sim2sim
