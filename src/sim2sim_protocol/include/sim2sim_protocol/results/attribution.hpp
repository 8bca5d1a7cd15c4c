// SPDX-License-Identifier: BSD-3-Clause
/// Why two simulators differ: how much of each gap between them every switch of the engine explains. The engine is any
/// with true/false parameters; its rows are a sweep over all combinations of some of them, or over those along random
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

/// One kind of gap, and who closes it. What is listed by switch is in the order of Attribution::switches.
struct AttributedGap {
  std::string name;           ///< key: "mean_pos_divergence", "lost_success"
  std::string title;          ///< for people: "position, open loop"
  std::string unit;           ///< "m", "rad"; none for success
  double all_off;             ///< mean over episodes
  double all_on;              ///< likewise
  std::vector<Share> shares;  ///< of each switch; together all_off - all_on
  // These need all combinations, and are empty without them.
  std::vector<double> gaps{};               ///< mean over episodes, by coalition: bit i is switch i on
  std::vector<Difference> alone{};          ///< what each switch closes if it is the first one
  std::vector<Difference> leave_one_out{};  ///< what comes back if it alone is off
  std::vector<Interaction> interactions{};  ///< of each pair
  Order best_order{};
  std::vector<double> staircase{};  ///< the gap along that order, from all off to all on
  // Beside it.
  Estimate null_model{};  ///< of a tee that never moves; NaN for success
  Estimate baseline{};    ///< of another engine; NaN without one
  Estimate floor{};       ///< of the reference against itself, start moved by 1e-6 m; NaN without a floor
};

struct Attribution {
  std::string reference;  ///< titles
  std::string engine;
  std::string policy;
  int episodes;
  std::string baseline;  ///< title of another engine, which is shown beside; empty: none
  std::size_t combinations;
  int orders;  ///< that were drawn; 0: all combinations
  std::vector<std::string> switches;
  std::vector<AttributedGap> gaps;  ///< position and angle, in open loop and re-anchored; then success
};

/// Of the sweep in `folder`; `baseline` is the folder of a run over the same episodes, or empty. Throws InvalidInput,
/// naming file or row, if it is none, if its rows differ in anything but true/false parameters, or if a combination of
/// these is not there; as readResults() and requirePairs(). Calls `go_on` before each row that it reads and each figure
/// that it attributes: what that throws ends it.
Attribution attribute(const std::filesystem::path& folder, const std::filesystem::path& baseline,
                      const std::function<void()>& go_on);

}  // namespace sim2sim
