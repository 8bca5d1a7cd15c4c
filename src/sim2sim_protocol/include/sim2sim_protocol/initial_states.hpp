// SPDX-License-Identifier: BSD-3-Clause
/// Starts that are given, in place of those that come of spawn seeds.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pusht_task/types.hpp"

namespace sim2sim {

/// The world state in which each episode of a run starts.
class InitialStates {
 public:
  /// Of the episodes `first`, `first` + 1, ...
  InitialStates(std::vector<pusht::WorldState> states, int first);

  /// Starts that are known by their hash alone, as a description of a run names them.
  static InitialStates named(std::string sha256);

  /// Throws std::out_of_range if the start of that episode is not known.
  const pusht::WorldState& at(int episode) const;

  /// The first 16 hex digits of the SHA-256 of that start: what a rollout from it depends on.
  std::string keyOf(int episode) const;

  /// All of them, as initialStatesCsv() writes them.
  std::string csv() const;

  /// "sha256:..." of csv().
  const std::string& hash() const { return hash_; }

 private:
  std::vector<pusht::WorldState> states_;
  int first_ = 0;
  std::string hash_;
};

/// The starts of `count` episodes from `first` on: the first rows of a CSV file. Its first line names the columns, in
/// any order, as the fields of WorldState.msg; velocities that are left out are zero. Throws InvalidInput with file,
/// line, value and rule, also for fewer rows and for what is no plausible start.
InitialStates readInitialStates(const std::filesystem::path& path, int first, int count);

/// The same of the text of such a file; the errors do not name a file.
InitialStates initialStatesFrom(const std::string& csv, int first, int count);

/// The same, for all who share them; none if `path` is empty.
std::shared_ptr<const InitialStates> givenInitialStates(const std::filesystem::path& path, int first, int count);

/// A file for readInitialStates(): all columns, every number in full precision.
std::string initialStatesCsv(const std::vector<pusht::WorldState>& states);

}  // namespace sim2sim
