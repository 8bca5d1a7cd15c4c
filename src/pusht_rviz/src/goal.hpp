// SPDX-License-Identifier: BSD-3-Clause
/// From the texts of the form to a goal of the action `compare`. A text that breaks a rule is refused with name, value
/// and rule, never corrected. Without widgets.
#pragma once

#include <pusht_msgs/CompareGoal.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "parameter_draft.hpp"

namespace pusht_rviz {

/// Names of the two options that a spawn seed depends on.
inline constexpr const char* kSeedOption = "seed";
inline constexpr const char* kFirstEpisodeOption = "first_episode";

/// Spawn seed of the first episode of a run with these options; none if a text is no number, or the sum no seed.
std::optional<std::uint64_t> spawnSeedOf(const std::string& seed, const std::string& first_episode);

/// A number that was read, or the rule that its text breaks.
struct Reading {
  std::uint64_t value = 0;  ///< holds without a refusal
  std::string refusal{};    ///< empty: none
};

/// First episode of a run with the option `seed` that begins with `spawn_seed`: the reverse of spawnSeedOf().
Reading firstEpisodeOf(const std::string& spawn_seed, const std::string& seed);

/// Name of the folder for the run after one whose results are in `folder`: "results" gives "results-2", that gives
/// "results-3". Empty stays empty.
std::string nextFolder(const std::string& folder);

/// Simulator in the form of the next run: its kind and parameters as typed.
struct SimulatorDraft {
  std::string kind{};  ///< empty: the node has not described itself
  ParameterDraft parameters{};
};

/// Content of the form of the next run.
struct RunDraft {
  ParameterDraft options;
  std::string spawn_seed;      ///< of the first episode
  bool spawned = true;         ///< false: initial states come from a file, and the spawn seed is not looked at
  std::string out;             ///< folder of the results; empty: the next free one
  std::string policy;          ///< namespace of its services; empty: the evaluator's default
  std::optional<double> rate;  ///< [control steps/s]; 0: as fast as possible; none: the evaluator's own
  SimulatorDraft reference;
  SimulatorDraft engine;
};

/// Rule that a field of the form breaks.
struct Refusal {
  std::string field;  ///< "spawn_seed", the name of an option, "reference.NAME" or "engine.NAME"
  std::string rule;
};

/// Goal of the next run, and the rules that the form breaks.
struct Draft {
  pusht_msgs::CompareGoal goal;  ///< holds without refusals
  std::vector<Refusal> refusals;
};

/// Goal for the next run, with the rules that the form breaks.
Draft goalFrom(const RunDraft& run);

}  // namespace pusht_rviz
