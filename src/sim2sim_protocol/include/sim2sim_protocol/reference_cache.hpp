// SPDX-License-Identifier: BSD-3-Clause
/// Rollouts of the reference, kept on disk: they depend on no knob of the engine.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "pusht_task/rollout.hpp"

namespace sim2sim {

/// A file for each rollout: FOLDER/HASH_OF_KEY/NAME_OF_START.ROLLOUT, a line of JSON and the numbers of
/// the trace as they are in memory. Several threads and runs may share a folder.
class ReferenceCache {
 public:
  /// `key` is all that a rollout depends on, besides its start. Throws RuntimeFault if the folder cannot be
  /// created.
  ReferenceCache(const std::filesystem::path& folder, nlohmann::json key);

  /// What the reference did from a start, if that is kept. `start` is its name: a spawn seed or a hash; `rollout` is
  /// "reference", or a probe of it. Throws BadDependency, naming the file, if it is damaged or belongs to another key,
  /// start or rollout.
  std::optional<pusht::Trace> find(const std::string& start, const std::string& rollout) const;

  /// Keeps a rollout that is not kept yet. Throws RuntimeFault if it cannot be written.
  void keep(const std::string& start, const std::string& rollout, const pusht::Trace& trace) const;

 private:
  std::filesystem::path fileOf(const std::string& start, const std::string& rollout) const;

  nlohmann::json key_;
  std::filesystem::path folder_;
};

}  // namespace sim2sim
