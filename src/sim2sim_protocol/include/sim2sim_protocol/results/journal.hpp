// SPDX-License-Identifier: BSD-3-Clause
/// Journal of the finished episodes of a running run, so that it can continue after an interruption.
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

/// Part of a finished episode that the results of a run need.
struct FinishedEpisode {
  EpisodeResult result;
  EpisodeBins bins{};  ///< empty if the run makes no bands
};

/// Text file: a line with all that decides the run, then a line for each episode, each behind the first digits of its
/// SHA-256. A line is written at once when its episode is added; an incomplete last line of a killed process is cut
/// off.
class Journal {
 public:
  /// Opens the journal at `path`, or begins it. `identity` is all that decides the bytes of the episodes. Throws
  /// InvalidInput with the first difference if the journal is of another run, BadDependency if it is damaged,
  /// RuntimeFault if it cannot be written.
  Journal(std::filesystem::path path, const Protocol& protocol, const nlohmann::json& identity);
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;
  ~Journal();

  /// Episodes that the journal had when it was opened, in the order in which they were added.
  const std::vector<FinishedEpisode>& kept() const { return kept_; }

  /// Indices of kept().
  std::set<int> keptIndices() const;

  /// Adds an episode. Throws RuntimeFault if it cannot be written.
  void add(const FinishedEpisode& episode);

  /// Removes the file, when the results have all that it holds.
  void remove();

 private:
  /// Reads the file. Returns whether it has no complete line.
  bool read(const Protocol& protocol, const nlohmann::json& identity);
  void append(const std::string& line);

  std::filesystem::path path_;
  std::string csv_head_;
  Protocol protocol_;
  std::vector<FinishedEpisode> kept_;
  int descriptor_ = -1;
};

}  // namespace sim2sim
