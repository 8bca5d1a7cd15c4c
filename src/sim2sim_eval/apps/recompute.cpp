// SPDX-License-Identifier: BSD-3-Clause
// Computes the results of a run again from its bag.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"
#include "sim2sim_eval/bag/recorded_run.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/run.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"
#include "sim2sim_protocol/results/traces.hpp"

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

struct Options {
  fs::path bag;
  fs::path out;
  bool overwrite = false;
  bool traces = false;  // write traces.npy
};

void recompute(const Options& options) {
  const fs::path& bag = options.bag;
  sim2sim::RunFolder folder(options.out, options.overwrite, "recompute");
  folder.refuseInputs({{"bag", bag}});
  std::vector<sim2sim::Episode> episodes;
  const auto keep = [&](sim2sim::Episode&& episode) {
    if (options.traces) {
      episodes.push_back(std::move(episode));
    }
  };
  sim2sim::RecordedRun recorded =
      sim2sim::loadFor(folder, [&] { return sim2sim::readRun(bag, sim2sim::interrupted, keep); });
  recorded.provenance["bag"] = bag.string();
  sim2sim::Run run(recorded.configuration, folder, recorded.provenance);
  run.take(std::move(recorded.episodes), std::move(recorded.bands));
  try {
    requireWhole(run, bag);
    if (options.traces) {
      std::sort(episodes.begin(), episodes.end(), [](const auto& a, const auto& b) { return a.index() < b.index(); });
      sim2sim::TraceFile traces(folder.tracesPath());
      std::for_each(episodes.begin(), episodes.end(), [&](const sim2sim::Episode& episode) { traces.add(episode); });
      traces.finish();
    }
  } catch (const std::exception& failure) {
    run.abandon(std::cout, failure);
    throw;
  }
  run.finish(std::cout);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Computes the results of a run again from its bag; they are the same, byte for byte.", "recompute");
  Options options;
  app.add_option("bag", options.bag, "compare.bag of a run")->required()->check(sim2sim::notEmpty());
  app.add_option("--out", options.out, "folder for the results (default: the next free results/recompute-N)")
      ->check(sim2sim::notEmpty());
  app.add_flag("--overwrite", options.overwrite, "replace results that are in the folder already");
  app.add_flag("--traces", options.traces, "write what the worlds did into traces.npy");
  return sim2sim::runCommand(app, argc, argv, [&] { recompute(options); });
}
