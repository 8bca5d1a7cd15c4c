// SPDX-License-Identifier: BSD-3-Clause
/// The folder that holds the results of one run.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "sim2sim_eval/protocol.hpp"
#include "sim2sim_eval/report.hpp"

namespace sim2sim {

/// How a run ended; status.json.
struct RunStatus {
  pusht::ExitCode exit_code = pusht::ExitCode::kOk;
  std::string reason;
  int episodes_finished = 0;
  int episodes = 0;
};

/// Every file in it is complete or absent. metrics.json speaks for a whole run: it is only written by finish().
class RunFolder {
 public:
  /// Throws InvalidInput if `path` holds results already and must not be overwritten, or is no folder.
  /// Creates nothing.
  RunFolder(std::filesystem::path path, bool overwrite);

  /// The first of results/compare-1, -2, ... below the current folder that is not there yet.
  static std::filesystem::path nextDefault();

  /// Creates the folder, without results of an earlier run, and writes what the run depends on.
  /// Throws RuntimeFault if it cannot be written.
  void begin(const nlohmann::json& provenance);

  /// The results of a whole run.
  void finish(const RunConfiguration& configuration, const std::vector<EpisodeResult>& episodes);

  /// The finished episodes of a run that ended early.
  void abandon(const std::vector<EpisodeResult>& episodes, const RunStatus& status);

  const std::filesystem::path& path() const { return path_; }

 private:
  void writeStatus(const RunStatus& status) const;

  std::filesystem::path path_;
};

}  // namespace sim2sim
