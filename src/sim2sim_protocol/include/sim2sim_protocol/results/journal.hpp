// SPDX-License-Identifier: BSD-3-Clause
/// The finished episodes of a run that is under way, so that it can go on after an interruption.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/bands.hpp"

namespace sim2sim {

/// A finished episode, as far as the results of a run need it.
struct FinishedEpisode {
  EpisodeResult result;
  EpisodeBins bins{};  ///< empty where no bands are made
};

/// A file of lines: what decides the run, then an episode in each, behind the first digits of its SHA-256. A line is
/// written when its episode has finished, at once and whole; the rest of a line in which a process was killed is cut
/// off.
class Journal {
 public:
  /// Opens the journal at `path`, or begins it. `identity` is all that decides the bytes of the episodes. Throws
  /// InvalidInput, naming the first difference, if the journal is of another run; BadDependency if it is damaged;
  /// RuntimeFault if it cannot be written.
  Journal(std::filesystem::path path, const Protocol& protocol, const nlohmann::json& identity);
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;
  ~Journal();

  /// The episodes that were there when the journal was opened, in the order in which they finished.
  const std::vector<FinishedEpisode>& kept() const { return kept_; }

  /// Their indices.
  std::set<int> keptIndices() const;

  /// Throws RuntimeFault if it cannot be written.
  void add(const FinishedEpisode& episode);

  /// Removes the file: the results have all that it holds.
  void remove();

 private:
  /// Whether there is no whole line.
  bool read(const Protocol& protocol, const nlohmann::json& identity);
  void append(const std::string& line);

  std::filesystem::path path_;
  std::string csv_head_;
  Protocol protocol_;
  std::vector<FinishedEpisode> kept_;
  int descriptor_ = -1;
};

}  // namespace sim2sim
