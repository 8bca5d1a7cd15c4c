// SPDX-License-Identifier: BSD-3-Clause
/// Rules of the fields of a goal of the action `compare`. A text that breaks one is refused with name, value and rule,
/// never corrected. Without widgets.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

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

}  // namespace pusht_rviz
