// SPDX-License-Identifier: BSD-3-Clause
/// Endings of closed loops over the episodes of a run: what a success rate is made of.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "sim2sim_protocol/episode.hpp"

namespace sim2sim {

/// Endings of one closed loop over episodes.
struct Endings {
  std::array<int, kEndingNames.size()> episodes{};             ///< number by Ending
  std::array<int, kPusherEndingNames.size()> stuck_pushers{};  ///< number of stuck ones by PusherEnding
  std::optional<int> median_still_step;                        ///< lower median over the stuck ones; empty: none
  int commands = 0;          ///< of the policy, in episodes of which it is known how many are at the limit
  int limited_commands = 0;  ///< those at the limit (RolloutResult::limited_commands)

  int of(Ending ending) const { return episodes[static_cast<std::size_t>(ending)]; }
  int failures() const { return of(Ending::kLost) + of(Ending::kStuck) + of(Ending::kMoving); }

  /// Whether most of the failures are stuck.
  bool areMostlyStuck() const { return 2 * of(Ending::kStuck) > failures(); }

  /// Share of commands at the limit; 0 if it is not known.
  double limitedShare() const { return commands == 0 ? 0.0 : static_cast<double>(limited_commands) / commands; }
};

/// Endings of both roles, and the stuck ones among the pairs of the two-by-two table.
struct EndingsOfPairs {
  Endings reference;
  Endings engine;
  int only_reference_engine_stuck = 0;  ///< episodes that the reference alone solves; the engine is stuck
  int only_engine_reference_stuck = 0;
  int neither_reference_stuck = 0;
  int neither_engine_stuck = 0;
};

/// Counts the endings of a closed loop; an episode whose rollout has none does not count.
Endings endingsOf(const std::vector<EpisodeResult>& episodes, std::size_t rollout);

/// Counts the endings of reference and engine.
EndingsOfPairs endingsOf(const std::vector<EpisodeResult>& episodes);

/// Share of commands at the limit from which on tables name it. The shipped policy has 0.007.
constexpr double kManyLimited = 0.05;
/// Share above which the policy is taken to answer in another unit.
constexpr double kMostLimited = 0.5;

/// "ending" in statistics.json: counts, and shares of the failures as shareJson().
nlohmann::json toJson(const Endings& endings, bool has_intervals);

}  // namespace sim2sim
