// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/results/run.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/reason.hpp"

namespace sim2sim {

Run::Run(RunConfiguration configuration, RunFolder& folder, const nlohmann::ordered_json& provenance)
    : configuration_(std::move(configuration)), folder_(folder) {
  folder_.begin(provenance, configuration_.protocol.episodes);
}

void Run::add(const EpisodeResult& episode) {
  const auto after = std::upper_bound(episodes_.begin(), episodes_.end(), episode,
                                      [](const auto& a, const auto& b) { return a.index < b.index; });
  episodes_.insert(after, episode);
  summary_.reset();
}

const Summary& Run::summary() const {
  if (!summary_) {
    summary_ = summarize(episodes_);
  }
  return *summary_;
}

std::string Run::progress() const {
  return std::to_string(episodes_.size()) + " of " + std::to_string(configuration_.protocol.episodes) + " episodes";
}

nlohmann::json Run::finish(std::ostream& out, int faults_survived) {
  const Summary& summary = this->summary();
  const Protocol& protocol = configuration_.protocol;
  out << "policy " << configuration_.policy << ", "
      << (protocol.starts ? "starts " + protocol.starts->hash() : "seed " + std::to_string(protocol.seed))
      << ", horizon " << configuration_.protocol.horizon << " control steps\n"
      << table(configuration_, summary) << "results: " << folder_.path().string() << "\n"
      << "config_hash: " << configurationHash(configuration_) << std::endl;
  nlohmann::json metrics = sim2sim::metrics(configuration_, summary);
  folder_.finish(metrics, episodes_, faults_survived);
  return metrics;
}

void Run::abandon(std::ostream& out, const std::exception& failure, int faults_survived) const {
  const pusht::ExitCode code = pusht::exitCodeOf(failure);
  if (!episodes_.empty() && code != pusht::ExitCode::kInternalError) {
    out << "NOT A WHOLE RUN: " << progress() << "\n"
        << table(configuration_, summary()) << "finished episodes: " << (folder_.path() / kEpisodesFile).string()
        << std::endl;
  }
  try {
    folder_.abandon(episodes_, {code, pusht::reasonOf(failure), static_cast<int>(episodes_.size()),
                                configuration_.protocol.episodes, faults_survived});
  } catch (const pusht::RuntimeFault&) {
    out << "the finished episodes could not be written" << std::endl;
  }
}

}  // namespace sim2sim
