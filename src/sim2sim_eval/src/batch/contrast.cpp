// SPDX-License-Identifier: BSD-3-Clause
#include "batch/contrast.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/json.hpp"

namespace sim2sim {

CommandWork contrastCommand(CLI::App& app) {
  const auto options = std::make_shared<ContrastOptions>();
  app.description(
      "Compares runs over the same episodes pair by pair, in other engines or of other policies: folders of results, "
      "or "
      "the rows of a sweep.");
  app.add_option("results", options->results, "folders of runs or sweeps")->required()->check(notEmpty());
  app.add_option("--against", options->against, "number of the run that the others are compared with, from 0")
      ->check(decimalInteger());
  app.add_option("--out", options->out, "JSON file for all figures")->check(notEmpty());
  options->required.declare(app);
  return [options](const CommandHost& host) { return contrast(*options, host); };
}

int contrastMain(int argc, char** argv) { return runCommand("contrast", contrastCommand, argc, argv); }

std::vector<RunResults> runsToContrast(const ContrastOptions& options) {
  std::vector<RunResults> runs;
  for (const std::string& folder : options.results) {
    for (const std::filesystem::path& run : runsIn(folder)) {
      requireNotInterrupted();
      runs.push_back(readResults(run));
    }
  }
  if (runs.size() < 2) {
    throw pusht::InvalidInput("results " + options.results.front() + ": is one run; name two, or a sweep");
  }
  if (options.against < 0 || options.against >= static_cast<int>(runs.size())) {
    throw pusht::InvalidInput("against " + std::to_string(options.against) + ": must be from 0 to " +
                              std::to_string(runs.size() - 1));
  }
  const auto baseline = runs.begin() + options.against;
  std::rotate(runs.begin(), baseline, baseline + 1);
  return runs;
}

nlohmann::json contrast(const ContrastOptions& options, const CommandHost& host) {
  const std::vector<Requirement> requirements = options.required.read();
  pusht::requireNewFile("out", options.out);
  std::vector<RunResults> runs = runsToContrast(options);
  for (const Requirement& requirement : requirements) {
    requirement.requireRuns(static_cast<int>(runs.size()));
  }
  const RunResults baseline = runs.front();
  runs.erase(runs.begin());
  const std::vector<Contrast> contrasts = contrastsOf(baseline, runs);
  const std::vector<RequirementResult> answers = judgeAll(
      requirements, [&](const Requirement& requirement) { return judge(requirement, baseline, runs, contrasts); });
  requireNotInterrupted();
  *host.out << table(baseline, runs, contrasts);
  nlohmann::json figures = toJson(baseline, runs, contrasts);
  if (!options.out.empty()) {
    pusht::writeNewFile("out", options.out, jsonText(figures));
  }
  if (!answers.empty()) {
    *host.out << "A: " << contrasts.front().against << "\n";
    for (std::size_t i = 0; i < contrasts.size(); ++i) {
      *host.out << letterOf(static_cast<int>(i) + 1) << ": " << contrasts[i].title << "\n";
    }
  }
  report("contrast", options.required, answers, *host.out);
  requireAllMet(answers);
  return figures;
}

}  // namespace sim2sim
