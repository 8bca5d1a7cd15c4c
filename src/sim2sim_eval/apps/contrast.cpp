// SPDX-License-Identifier: BSD-3-Clause
// Compares runs over the same episodes pair by pair.
#include "sim2sim_protocol/results/contrast.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/json.hpp"

namespace {

namespace fs = std::filesystem;

/// All runs in the folders; one of them, the baseline, is moved to the front.
std::vector<sim2sim::RunResults> read(const std::vector<std::string>& folders, int against) {
  std::vector<sim2sim::RunResults> runs;
  for (const std::string& folder : folders) {
    for (const fs::path& run : sim2sim::runsIn(folder)) {
      sim2sim::requireNotInterrupted();
      runs.push_back(sim2sim::readResults(run));
    }
  }
  if (runs.size() < 2) {
    throw pusht::InvalidInput("results " + folders.front() + ": is one run; name two, or a sweep");
  }
  if (against < 0 || against >= static_cast<int>(runs.size())) {
    throw pusht::InvalidInput("against " + std::to_string(against) + ": must be from 0 to " +
                              std::to_string(runs.size() - 1));
  }
  std::rotate(runs.begin(), runs.begin() + against, runs.begin() + against + 1);
  return runs;
}

void contrast(const std::vector<std::string>& folders, int against, const fs::path& out) {
  sim2sim::requireNewFile("out", out);
  std::vector<sim2sim::RunResults> runs = read(folders, against);
  const sim2sim::RunResults baseline = runs.front();
  runs.erase(runs.begin());
  const std::vector<sim2sim::Contrast> contrasts = sim2sim::contrast(baseline, runs);
  sim2sim::requireNotInterrupted();
  std::cout << sim2sim::table(baseline, runs, contrasts);
  if (!out.empty()) {
    pusht::writeFile(out, sim2sim::jsonText(sim2sim::toJson(baseline, runs, contrasts)));
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Compares runs over the same episodes pair by pair: two folders of results, or the rows of a sweep.",
               "contrast");
  std::vector<std::string> folders;
  int against = 0;
  std::string out;
  app.add_option("results", folders, "folders of runs or sweeps")->required()->check(sim2sim::notEmpty());
  app.add_option("--against", against, "number of the run that the others are compared with, from 0")
      ->check(sim2sim::decimalInteger());
  app.add_option("--out", out, "JSON file for all figures")->check(sim2sim::notEmpty());
  return sim2sim::runCommand(app, argc, argv, [&] { contrast(folders, against, out); });
}
