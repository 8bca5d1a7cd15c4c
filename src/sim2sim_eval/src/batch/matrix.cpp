// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
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
namespace {

struct MatrixOptions {
  std::filesystem::path sweep;
  std::vector<std::string> groups;
  std::vector<std::string> pairs;    ///< names of policies; empty: none are compared
  std::filesystem::path hypotheses;  ///< file for readHypotheses(); empty: none
  bool overwrite = false;
};

/// Prints the matrix of a sweep, and writes matrix.json and matrix.csv into its folder: both, or none. Returns the
/// content of the first.
nlohmann::json makeMatrix(const MatrixOptions& options, const CommandHost& host) {
  const DerivedFiles files("matrix", options.sweep, kMatrixFile, kMatrixTable, options.overwrite);
  const std::vector<Hypothesis> expected =
      options.hypotheses.empty() ? std::vector<Hypothesis>() : readHypotheses(options.hypotheses);
  const Matrix matrix = readMatrix(options.sweep, options.groups, [] { requireNotInterrupted(); });
  const std::vector<HypothesisResult> tested = test(matrix, expected);
  const std::vector<PolicyPair> pairs = pairsOf(matrix, options.pairs);
  requireNotInterrupted();
  *host.out << table(matrix) << table(matrix, pairs) << table(tested);
  nlohmann::json content = toJson(matrix);
  content["hypotheses"] = toJson(tested);
  if (!pairs.empty()) {
    content["pairs"] = toJson(matrix, pairs);
  }
  files.write(content, toCsv(matrix));
  return content;
}

}  // namespace

CommandWork matrixCommand(CLI::App& app) {
  const auto options = std::make_shared<MatrixOptions>();
  app.description(
      "Says how each policy of a sweep does in each simulator, what it keeps of its success in its reference, and what "
      "holds for groups of policies. Writes matrix.json and matrix.csv into the folder of the sweep.");
  app.add_option("sweep", options->sweep, "folder of the sweep, from a plan that lists policies")
      ->required()
      ->check(notEmpty());
  app.add_option("--group", options->groups, "only the policies of this group of the plan; may be repeated")
      ->type_size(1)
      ->allow_extra_args(false)
      ->check(notEmpty());
  app.add_option("--pair", options->pairs,
                 "two policies or more, each of which is compared with the others start by start")
      ->check(notEmpty());
  app.add_option("--hypotheses", options->hypotheses,
                 "YAML file with differences between groups of policies that were expected before the sweep was run; "
                 "each is tested")
      ->check(notEmpty());
  app.add_flag("--overwrite", options->overwrite, "replace a matrix that is in the folder already");
  return [options](const CommandHost& host) { return makeMatrix(*options, host); };
}

int matrixMain(int argc, char** argv) { return runCommand("matrix", matrixCommand, argc, argv); }

}  // namespace sim2sim
