// SPDX-License-Identifier: BSD-3-Clause
/// Results of runs and sweeps, as read from their folders.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Results of a run, or of a row of a sweep, as read from its folder.
struct RunResults {
  std::filesystem::path folder;
  nlohmann::json metrics;
  Protocol protocol;
  std::vector<EpisodeResult> episodes;
  /// Digest of the policy's file in provenance.json. Empty: of a policy without a file, or a row of a sweep.
  std::string policy_sha256{};

  /// Name for people of the engine, with changed parameters: "two-mass engine, block_damp 20.0".
  std::string title() const;

  /// Policy as it was named: "bc", or a path.
  std::string policy() const;

  /// Engine in `metrics`: its name, title, parameters, and the names of the changed ones.
  const nlohmann::json& engine() const;
};

/// Reads the results of a whole run. Throws InvalidInput with the file if `folder` does not hold them.
RunResults readResults(const std::filesystem::path& folder);

/// Sweep, or shard of one. sweep.json describes it; rows/000, rows/001, ... hold metrics.json and episodes.csv of each
/// row, as a run with the row's parameters writes them. Each file is complete or absent.
struct SweepResults {
  std::filesystem::path folder;
  nlohmann::json description;  ///< "sweep" in sweep.json: an object

  /// Throws InvalidInput for one shard of a sweep.
  void requireWhole() const;

  /// Content of provenance.json; its "code" is the fingerprint of the build. Throws InvalidInput if it is no object.
  nlohmann::json provenance() const;

  /// Folders of all rows, in order. Throws InvalidInput if there are none, or one has not finished.
  std::vector<std::filesystem::path> rowFolders() const;

  /// Results of all rows, in order. Calls `go_on` before each; it may throw to end the work. Throws as rowFolders() and
  /// readResults().
  std::vector<RunResults> readRows(const std::function<void()>& go_on) const;
};

/// Reads sweep.json. Throws InvalidInput with the file if the folder has none.
SweepResults readSweep(const std::filesystem::path& folder);

/// Likewise, of a sweep in one piece. Throws InvalidInput for a run, which is not `needed`, and for a shard.
SweepResults readWholeSweep(const std::filesystem::path& folder, const std::string& needed);

/// Folders of all rows of a sweep, in order; `folder` itself if it is a run. Throws InvalidInput if it is neither.
std::vector<std::filesystem::path> runsIn(const std::filesystem::path& folder);

/// What two runs that pair differ in, if in anything.
enum class Pairing {
  kEngines,   ///< the reference did the same in both
  kPolicies,  ///< or in how many actions of its answers are executed (RunOptions::execute)
};

/// Pairing of two runs. Throws InvalidInput with the first difference unless initial states, options, probes and
/// reference are the same, and either the policy, with what it does in the reference, or the engine.
Pairing pairingOf(const RunResults& baseline, const RunResults& other);

/// Throws InvalidInput, likewise, unless the runs pair as kEngines.
void requirePairs(const RunResults& baseline, const RunResults& other);

}  // namespace sim2sim
