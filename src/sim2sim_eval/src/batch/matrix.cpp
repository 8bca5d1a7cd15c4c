// SPDX-License-Identifier: BSD-3-Clause
#include "batch/matrix.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "batch/derived_files.hpp"
#include "batch/hypotheses_file.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/hypotheses_files.hpp"
#include "sim2sim_protocol/results/matrix_files.hpp"
#include "sim2sim_protocol/results/result_files.hpp"

namespace sim2sim {
void MatrixOptions::declare(CLI::App& app) {
  app.add_option("sweep", sweep, "folder of the sweep, from a plan that lists policies")->required()->check(notEmpty());
  app.add_option("--group", groups, "only the policies of this group of the plan; may be repeated")
      ->type_size(1)
      ->allow_extra_args(false)
      ->check(notEmpty());
  app.add_option("--hypotheses", hypotheses,
                 "YAML file with differences between groups of policies that were expected before the sweep was run; "
                 "each is tested")
      ->check(notEmpty());
  app.add_flag("--overwrite", overwrite, "replace a matrix that is in the folder already");
}

void matrix(const MatrixOptions& options) {
  const DerivedFiles files("matrix", options.sweep, kMatrixFile, kMatrixTable, options.overwrite);
  const std::vector<Hypothesis> hypotheses =
      options.hypotheses.empty() ? std::vector<Hypothesis>() : readHypotheses(options.hypotheses);
  const Matrix matrix = readMatrix(options.sweep, options.groups, [] { requireNotInterrupted(); });
  const std::vector<HypothesisResult> tested = test(matrix, hypotheses);
  requireNotInterrupted();
  std::cout << table(matrix) << table(tested);
  nlohmann::json content = toJson(matrix);
  content["hypotheses"] = toJson(tested);
  files.write(content, toCsv(matrix));
}

}  // namespace sim2sim
