// SPDX-License-Identifier: BSD-3-Clause
/// A run from its configuration to its results, wherever its worlds are.
#pragma once

#include <exception>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/run_folder.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_statistics/sequential.hpp"

namespace sim2sim {

/// Whether a run needs no further episodes than these, which are by index.
bool isWhole(const RunConfiguration& run, const std::vector<EpisodeResult>& episodes);

/// Gathers the finished episodes of a run, and tells in its folder and as a table what they say.
class Run {
 public:
  /// Begins `folder`, which must outlive the run; `identity` as for RunFolder::begin(). A run that goes on has the
  /// episodes of its journal.
  Run(RunConfiguration configuration, RunFolder& folder, const nlohmann::ordered_json& provenance,
      const nlohmann::json& identity = {});

  const RunConfiguration& configuration() const { return configuration_; }

  /// In any order, each once; in that of their indices if the run ends when it is decided. Returns what it adds.
  EpisodeResult add(const Episode& episode);

  /// Episodes that have been gathered elsewhere, instead of add().
  void take(std::vector<EpisodeResult> episodes, DivergenceBands bands);

  /// The finished episodes, by index.
  const std::vector<EpisodeResult>& episodes() const { return episodes_; }
  /// Of the finished episodes; there must be one.
  const Summary& summary() const;
  bool whole() const { return isWhole(configuration_, episodes_); }

  /// Whether no further episode is needed; only of a run that ends when it is decided.
  bool decided() const { return bet_ && bet_->verdict() != Verdict::kUndecided; }

  /// "3 of 50 episodes"
  std::string progress() const;

  /// The results of a whole run. Returns its metrics; throws as RunFolder::finish does.
  nlohmann::json finish(std::ostream& out, int faults_survived = 0);

  /// Keeps what a run has found that `failure` ended, and says so. What keeps it from being written is not an error:
  /// `failure` is the one to report.
  void abandon(std::ostream& out, const std::exception& failure, int faults_survived = 0) const;

 private:
  void add(const FinishedEpisode& finished);
  void watch(const EpisodeResult& episode);

  RunConfiguration configuration_;
  RunFolder& folder_;
  std::vector<EpisodeResult> episodes_;
  DivergenceBands bands_;
  std::optional<TransferBet> bet_;
  mutable std::optional<Summary> summary_;  // of these episodes, if it has been asked for
};

}  // namespace sim2sim
