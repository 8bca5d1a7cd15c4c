// SPDX-License-Identifier: BSD-3-Clause
/// A run from its configuration to its results. It is the same live, in batch and from a bag.
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

/// Whether `episodes`, which are by index, are all that the run needs.
bool isWhole(const RunConfiguration& run, const std::vector<EpisodeResult>& episodes);

/// Collects the finished episodes of a run and writes its results, as files and as a table.
class Run {
 public:
  /// Begins `folder`, which must outlive the run; `identity` as for RunFolder::begin(), and throws as it. A run that
  /// continues has the episodes of its journal. Without a folder (null) the run writes no files.
  Run(RunConfiguration configuration, RunFolder* folder, const nlohmann::ordered_json& provenance,
      const nlohmann::json& identity = {});

  const RunConfiguration& configuration() const { return configuration_; }

  /// Adds a finished episode, each once, and returns its result. Any order will do; in a run that ends when it is
  /// decided, episodes must come in the order of their indices. Throws RuntimeFault if the journal cannot be written.
  EpisodeResult add(const Episode& episode);

  /// Sets episodes that were collected elsewhere, instead of add().
  void take(std::vector<EpisodeResult> episodes, DivergenceBands bands);

  /// Finished episodes, by index.
  const std::vector<EpisodeResult>& episodes() const { return episodes_; }
  /// Summary of the finished episodes; there must be one.
  const Summary& summary() const;
  bool whole() const { return isWhole(configuration_, episodes_); }

  /// Whether a run that ends when it is decided is decided; false for other runs.
  bool decided() const { return bet_ && bet_->verdict() != Verdict::kUndecided; }

  /// Progress for people: "3 of 50 episodes".
  std::string progress() const;

  /// Writes the results of a whole run, prints its table to `out`, and returns its metrics. Throws as
  /// RunFolder::finish().
  nlohmann::json finish(std::ostream& out, int faults_survived = 0);

  /// Writes the finished episodes of a run that `failure` ended. A further failure to write them is only printed:
  /// `failure` is the one to report.
  void abandon(std::ostream& out, const std::exception& failure, int faults_survived = 0) const;

 private:
  void add(const FinishedEpisode& finished);
  void watch(const EpisodeResult& episode);

  RunConfiguration configuration_;
  RunFolder* folder_;  // null: none
  std::vector<EpisodeResult> episodes_;
  DivergenceBands bands_;
  std::string note_;  // as noteOnNoise()
  std::optional<TransferBet> bet_;
  mutable std::optional<Summary> summary_;  // of these episodes, if it has been asked for
};

}  // namespace sim2sim
