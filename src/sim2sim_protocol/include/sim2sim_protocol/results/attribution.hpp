// SPDX-License-Identifier: BSD-3-Clause
/// Attribution: how much of the gap between two simulators each switch of the engine explains. A switch is a true/false
/// parameter for a modeling choice. The rows of a sweep are all combinations of some switches, or those along random
/// orders of switching them on.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim2sim_statistics/cooperative_game.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/shapley.hpp"

namespace sim2sim {

/// One kind of gap and the share of each switch in it. Lists by switch are in the order of Attribution::switches.
struct AttributedGap {
  std::string name;           ///< key: "mean_pos_divergence", "lost_success"
  std::string title;          ///< for people: "position, open loop"
  std::string unit;           ///< "m", "rad"; none for success
  double all_off;             ///< mean gap over episodes with all switches off
  double all_on;              ///< mean gap over episodes with all switches on
  std::vector<Share> shares;  ///< by switch; their sum is all_off - all_on
  // Empty unless the sweep has all combinations:
  std::vector<double> gaps{};               ///< mean gap over episodes, by coalition: bit i is switch i
  std::vector<Difference> alone{};          ///< gap that each switch closes as the first one
  std::vector<Difference> leave_one_out{};  ///< gap that comes back if the switch alone is off
  std::vector<Interaction> interactions{};  ///< by pair of switches
  Order best_order{};
  std::vector<double> staircase{};  ///< mean gaps along best_order, from all off to all on
  std::vector<Difference> steps{};  ///< gap that each step of the staircase closes
  // Baselines:
  Estimate null_model{};  ///< gap of a tee that never moves; NaN for success
  Estimate baseline{};    ///< gap of another engine; NaN without one
  Estimate floor{};       ///< gap of the reference from itself, initial state moved by 1e-6 m; NaN without a floor
};

/// Attribution of all gaps of a sweep.
struct Attribution {
  std::string reference;  ///< title
  std::string engine;     ///< title
  std::string policy;
  int episodes;
  std::string baseline;      ///< title of another engine to compare with; empty: none
  std::size_t combinations;  ///< number of rows
  int orders;                ///< number of random orders; 0: all combinations
  std::vector<std::string> switches;
  std::vector<AttributedGap> gaps;  ///< position and angle in open loop and in each state-reset replay; then success
};

/// Attributes the gaps of the sweep in `folder`; `baseline` is the folder of a run over the same episodes, or empty.
/// Throws InvalidInput with file or row if `folder` is no sweep, if its rows differ in anything but switches, or if a
/// combination is missing; also as readResults() and requirePairs(). Calls `go_on` before each row that it reads and
/// each gap that it attributes; it may throw to end the work.
Attribution readAttribution(const std::filesystem::path& folder, const std::filesystem::path& baseline,
                            const std::function<void()>& go_on);

}  // namespace sim2sim
