// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/run.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/reason.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/table.hpp"

namespace sim2sim {
namespace {

void add(TransferBet& bet, const EpisodeResult& episode) {
  bet.add(episode.rollouts[kReferenceClosed].success, episode.rollouts[kEngineClosed].success);
}

}  // namespace

bool isWhole(const RunConfiguration& run, const std::vector<EpisodeResult>& episodes) {
  if (static_cast<int>(episodes.size()) == run.protocol.episodes) {
    return true;
  }
  if (!run.protocol.until_decided) {
    return false;
  }
  TransferBet bet(*run.protocol.until_decided);
  std::for_each(episodes.begin(), episodes.end(), [&](const EpisodeResult& episode) { add(bet, episode); });
  return bet.verdict() != Verdict::kUndecided;
}

Run::Run(RunConfiguration configuration, RunFolder* folder, const nlohmann::ordered_json& provenance,
         const nlohmann::json& identity)
    : configuration_(std::move(configuration)),
      folder_(folder),
      bands_(configuration_.protocol),
      note_(noteOnNoise(configuration_, provenance)) {
  if (configuration_.protocol.until_decided) {
    bet_.emplace(*configuration_.protocol.until_decided);
  }
  if (folder_ == nullptr) {
    return;
  }
  folder_->begin(provenance, configuration_.protocol, identity);
  if (const Journal* journal = folder_->journal()) {
    for (const FinishedEpisode& episode : journal->kept()) {
      add(episode);
    }
  }
}

EpisodeResult Run::add(const Episode& episode) {
  FinishedEpisode finished{episode.result(), DivergenceBands::binsOf(configuration_.protocol, episode)};
  if (Journal* journal = folder_ != nullptr ? folder_->journal() : nullptr) {
    journal->add(finished);
  }
  add(finished);
  return std::move(finished.result);
}

void Run::add(const FinishedEpisode& finished) {
  const EpisodeResult& result = finished.result;
  const auto after = std::upper_bound(episodes_.begin(), episodes_.end(), result,
                                      [](const auto& a, const auto& b) { return a.index < b.index; });
  episodes_.insert(after, result);
  bands_.add(finished.bins);
  watch(result);
  summary_.reset();
}

void Run::take(std::vector<EpisodeResult> episodes, DivergenceBands bands) {
  episodes_ = std::move(episodes);
  bands_ = std::move(bands);
  std::for_each(episodes_.begin(), episodes_.end(), [this](const EpisodeResult& episode) { watch(episode); });
  summary_.reset();
}

void Run::watch(const EpisodeResult& episode) {
  if (bet_) {
    sim2sim::add(*bet_, episode);
  }
}

const Summary& Run::summary() const {
  if (!summary_) {
    summary_ = summarize(configuration_.protocol, episodes_);
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
      << (protocol.initial_states ? "starts " + protocol.initial_states->hash()
                                  : "seed " + std::to_string(protocol.seed))
      << ", horizon " << configuration_.protocol.horizon << " control steps\n"
      << (bet_ ? decisionText(*bet_, *configuration_.protocol.until_decided) : "") << table(configuration_, summary)
      << (note_.empty() ? "" : note_ + "\n")
      << (folder_ != nullptr ? "results: " + folder_->path().string() + "\n" : "")
      << "config_hash: " << configurationHash(configuration_) << std::endl;
  nlohmann::json metrics = sim2sim::metrics(configuration_, summary);
  if (bet_) {
    metrics["decision"] = decision(*bet_, *configuration_.protocol.until_decided);
  }
  if (folder_ != nullptr) {
    folder_->finish(configuration_, metrics, episodes_, bands_, faults_survived);
  }
  return metrics;
}

void Run::abandon(std::ostream& out, const std::exception& failure, int faults_survived) const {
  if (folder_ == nullptr) {
    return;
  }
  const pusht::ExitCode code = pusht::exitCodeOf(failure);
  if (!episodes_.empty() && code != pusht::ExitCode::kInternalError) {
    out << "NOT A WHOLE RUN: " << progress() << "\n"
        << table(configuration_, summary()) << "finished episodes: " << (folder_->path() / kEpisodesFile).string()
        << std::endl;
  }
  try {
    folder_->abandon(configuration_.protocol, episodes_,
                     {code, pusht::reasonOf(failure), static_cast<int>(episodes_.size()),
                      configuration_.protocol.episodes, faults_survived});
  } catch (const pusht::RuntimeFault&) {
    out << "the finished episodes could not be written" << std::endl;
  }
}

}  // namespace sim2sim
