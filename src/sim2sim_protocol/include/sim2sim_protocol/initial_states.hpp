// SPDX-License-Identifier: BSD-3-Clause
/// Initial states of episodes that are given in a file, in place of those of the spawn seeds.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pusht_task/task.hpp"
#include "pusht_task/types.hpp"

namespace sim2sim {

/// Initial state of each episode of a run.
class InitialStates {
 public:
  /// `states` are those of the episodes `first`, `first` + 1, ...
  InitialStates(std::vector<pusht::WorldState> states, int first);

  /// Initial states that are known by their hash alone, as in the description of a run.
  static InitialStates named(std::string sha256);

  /// Initial state of an episode. Throws std::out_of_range if it is not known.
  const pusht::WorldState& at(int episode) const;

  /// Cache key of an episode's initial state: the first 16 hex digits of its SHA-256. Throws as at().
  std::string keyOf(int episode) const;

  /// Text of initialStatesCsv() for all of them.
  std::string csv() const;

  /// SHA-256 of csv(), as "sha256:...".
  const std::string& hash() const { return hash_; }

 private:
  std::vector<pusht::WorldState> states_;
  int first_ = 0;
  std::string hash_;
};

/// Reads the initial states of `count` episodes from `first` on: the first rows of a CSV file. Its first line names the
/// columns, in any order, as the fields of WorldState.msg, in their units and frame; velocities that are left out are
/// 0. A task with a frame of its own also takes positions and angle in that: "pusher_x_px", ..., "tee_angle". Throws
/// InvalidInput with file, line, value and rule for bad text, too few rows, or an implausible state.
InitialStates readInitialStates(const std::filesystem::path& path, int first, int count,
                                const pusht::Task& task = pusht::fullCircle());

/// Reads the text of such a file. Throws InvalidInput as readInitialStates(), without a file.
InitialStates initialStatesFrom(const std::string& csv, int first, int count,
                                const pusht::Task& task = pusht::fullCircle());

/// Initial states of a run from a file, as readInitialStates(); null if `path` is empty. Throws InvalidInput with file,
/// line, value and rule also for bodies beyond the table; for one start in two lines, as Protocol::repeats plays a
/// start several times; and, unless they `may_overlap`, for bodies that overlap by more than a contact does.
std::shared_ptr<const InitialStates> givenInitialStates(const std::filesystem::path& path, int first, int count,
                                                        bool may_overlap,
                                                        const pusht::Task& task = pusht::fullCircle());

/// Text of a file for readInitialStates(): all columns, every number in full precision.
std::string initialStatesCsv(const std::vector<pusht::WorldState>& states);

}  // namespace sim2sim
