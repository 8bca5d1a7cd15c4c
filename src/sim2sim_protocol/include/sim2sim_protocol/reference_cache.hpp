// SPDX-License-Identifier: BSD-3-Clause
/// Cache of the reference's rollouts on disk. They depend on no parameter of the engine.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "pusht_task/rollout.hpp"

namespace sim2sim {

/// Name under which what depends on `key` is kept on disk: the first 16 hex digits of its hash.
std::string keptName(const nlohmann::json& key);

/// Name in the cache of the closed loop in the reference; probes have their own names.
inline constexpr const char* kReferenceRollout = "reference";

/// Cache with a file for each rollout: FOLDER/HASH/STATE.ROLLOUT, a line of JSON and the trace's numbers as they are in
/// memory. HASH is that of the cache's key, STATE the key of an episode (Protocol::cacheKey()). Threads and processes
/// may share a folder.
class ReferenceCache {
 public:
  /// `key` is all that a rollout depends on besides its initial state. Throws RuntimeFault if the folder cannot be
  /// created.
  ReferenceCache(const std::filesystem::path& folder, nlohmann::json key);

  /// Regular expressions of the names of the folder of a key, and of the files in it.
  static std::string folderPattern();
  static std::string filePattern();

  /// Trace of a rollout; empty if it is not in the cache. `state` is the key of its episode, `rollout` is
  /// kReferenceRollout or the name of a probe. Throws BadDependency with the file if that is damaged or belongs to
  /// another key, state or rollout.
  std::optional<pusht::Trace> find(const std::string& state, const std::string& rollout) const;

  /// Adds a rollout unless it is there. Throws RuntimeFault if it cannot be written.
  void keep(const std::string& state, const std::string& rollout, const pusht::Trace& trace) const;

 private:
  std::filesystem::path fileOf(const std::string& state, const std::string& rollout) const;

  nlohmann::json key_;
  std::filesystem::path folder_;
};

}  // namespace sim2sim
