// SPDX-License-Identifier: BSD-3-Clause
// Computes the results of a run again from its bag.
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>
#include <utility>

#include "pusht_task/error.hpp"
#include "sim2sim_eval/bag/recorded_run.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_eval/results/run.hpp"
#include "sim2sim_eval/results/run_folder.hpp"

namespace {

namespace fs = std::filesystem;

/// The episodes that a run lacks, as text: "3, 5 to 9".
std::string missingEpisodes(const sim2sim::Run& run) {
  const sim2sim::Protocol& protocol = run.configuration().protocol;
  std::string text;
  int next = protocol.first_episode;
  const auto miss_until = [&](int end) {
    if (next < end) {
      text += (text.empty() ? "" : ", ") + std::to_string(next);
      text += next < end - 1 ? " to " + std::to_string(end - 1) : "";
    }
    next = end + 1;
  };
  for (const sim2sim::EpisodeResult& episode : run.episodes()) {
    miss_until(episode.index);
  }
  miss_until(protocol.lastEpisode() + 1);
  return text;
}

void requireWhole(const sim2sim::Run& run, const fs::path& bag) {
  if (!run.whole()) {
    throw pusht::RuntimeFault("bag " + bag.string() + ": episodes " + missingEpisodes(run) + " are missing");
  }
}

void recompute(const fs::path& bag, const fs::path& out, bool overwrite) {
  sim2sim::RunFolder folder(out, overwrite, "recompute");
  folder.refuseInputs({{"bag", bag}});
  sim2sim::RecordedRun recorded = sim2sim::loadFor(folder, [&] { return sim2sim::readRun(bag, sim2sim::interrupted); });
  recorded.provenance["bag"] = bag.string();
  sim2sim::Run run(recorded.configuration, folder, recorded.provenance);
  run.take(std::move(recorded.episodes), std::move(recorded.bands));
  try {
    requireWhole(run, bag);
  } catch (const std::exception& failure) {
    run.abandon(std::cout, failure);
    throw;
  }
  run.finish(std::cout);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Computes the results of a run again from its bag; they are the same, byte for byte.", "recompute");
  std::string bag;
  std::string out;
  bool overwrite = false;
  app.add_option("bag", bag, "compare.bag of a run")->required();
  app.add_option("--out", out, "folder for the results (default: the next free results/recompute-N)");
  app.add_flag("--overwrite", overwrite, "replace results that are in the folder already");
  return sim2sim::runCommand(app, argc, argv, [&] { recompute(bag, out, overwrite); });
}
