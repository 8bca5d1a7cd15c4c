// SPDX-License-Identifier: BSD-3-Clause
#include "batch/recompute.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <iostream>
#include <utility>
#include <vector>

#include "bag/recorded_run.hpp"
#include "pusht_task/error.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/run.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"
#include "sim2sim_protocol/results/traces.hpp"

namespace sim2sim {
namespace {

void requireWhole(const Run& run, const std::filesystem::path& bag) {
  if (!run.whole()) {
    throw pusht::RuntimeFault("bag " + bag.string() + ": episodes " +
                              missingEpisodes(run.configuration().protocol, run.episodes()) + " are missing");
  }
}

}  // namespace

int recomputeMain(int argc, char** argv) {
  RecomputeOptions options;
  CLI::App app("Computes the results of a run again from its bag; they are the same, byte for byte.", "recompute");
  app.add_option("bag", options.bag, "compare.bag of a run")->required()->check(notEmpty());
  app.add_option("--out", options.out, "folder for the results (default: the next free results/recompute-N)")
      ->check(notEmpty());
  app.add_flag("--overwrite", options.overwrite, "replace results that are in the folder already");
  app.add_flag("--traces", options.traces, "write what the worlds did into traces.npy");
  return runCommand(app, argc, argv, [&] { recompute(options); });
}

std::string missingEpisodes(const Protocol& protocol, const std::vector<EpisodeResult>& episodes) {
  std::string text;
  int next = protocol.first_episode;
  const auto miss_until = [&](int end) {
    if (next < end) {
      text += (text.empty() ? "" : ", ") + std::to_string(next);
      text += next < end - 1 ? " to " + std::to_string(end - 1) : "";
    }
    next = end + 1;
  };
  for (const EpisodeResult& episode : episodes) {
    miss_until(episode.index);
  }
  miss_until(protocol.lastEpisode() + 1);
  return text;
}

void recompute(const RecomputeOptions& options) {
  RunFolder folder(options.out, options.overwrite, "recompute");
  folder.refuseInputs({{"bag", options.bag}});
  std::vector<Episode> episodes;
  const auto keep = [&](Episode&& episode) {
    if (options.traces) {
      episodes.push_back(std::move(episode));
    }
  };
  RecordedRun recorded = loadFor(folder, [&] { return readRun(options.bag, interrupted, keep); });
  recorded.provenance["bag"] = options.bag.string();
  Run run(recorded.configuration, &folder, recorded.provenance);
  run.take(std::move(recorded.episodes), std::move(recorded.bands));
  try {
    requireWhole(run, options.bag);
    if (options.traces) {
      std::sort(episodes.begin(), episodes.end(), [](const auto& a, const auto& b) { return a.index() < b.index(); });
      TraceFile traces(folder.tracesPath());
      std::for_each(episodes.begin(), episodes.end(), [&](const Episode& episode) { traces.add(episode); });
      traces.finish();
    }
  } catch (const std::exception& failure) {
    run.abandon(std::cout, failure);
    throw;
  }
  run.finish(std::cout);
}

}  // namespace sim2sim
