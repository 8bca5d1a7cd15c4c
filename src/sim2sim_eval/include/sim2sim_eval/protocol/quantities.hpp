// SPDX-License-Identifier: BSD-3-Clause
/// The figures of a rollout, each listed once. Columns of episodes.csv and sweep.csv, keys of metrics.json, messages
/// and tables take names, units and order from here: a new figure is a line in kQuantities and the function that it
/// names.
#pragma once

#include <array>
#include <cstddef>
#include <stdexcept>
#include <string_view>

#include "pusht_task/rollout.hpp"

namespace sim2sim {

// How to compute them, from a rollout and what the reference did in the same episode.

/// [m] from the tee's origin to the target, after the last step.
double finalPositionError(const pusht::Rollout& rollout, const pusht::Trace& reference);
/// [rad] of the tee's yaw from the target's, after the last step; in [0, pi].
double finalAngleError(const pusht::Rollout& rollout, const pusht::Trace& reference);
/// [m] from the reference's tee, mean over the steps that both have.
double meanPositionDivergence(const pusht::Rollout& rollout, const pusht::Trace& reference);
/// [rad] from the reference's yaw, mean over the steps that both have; in [0, pi].
double meanAngleDivergence(const pusht::Rollout& rollout, const pusht::Trace& reference);

/// What is measured of every rollout.
struct Quantity {
  const char* name;   ///< as in messages; with the unit, a column of episodes.csv
  const char* unit;   ///< "m"
  bool compares;      ///< with the reference, which hence has none of its own
  const char* label;  ///< in tables, where what compares has a line
  double (*compute)(const pusht::Rollout& rollout, const pusht::Trace& reference);
  const char* course_key;  ///< in metrics.json, of its mean over the replays; nullptr where the course has none
};

inline constexpr std::array kQuantities = {
    Quantity{"final_position_error", "m", false, "", finalPositionError, nullptr},
    Quantity{"final_angle_error", "rad", false, "", finalAngleError, nullptr},
    Quantity{"mean_position_divergence", "m", true, "position", meanPositionDivergence, "mean_pos_divergence"},
    Quantity{"mean_angle_divergence", "rad", true, "angle", meanAngleDivergence, "mean_ang_divergence"},
};

/// One number for each of kQuantities; NaN where there is none.
using QuantityValues = std::array<double, kQuantities.size()>;

/// The place of a quantity in kQuantities. Throws std::out_of_range if there is none of that name.
constexpr std::size_t quantityIndex(std::string_view name) {
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    if (name == kQuantities[i].name) {
      return i;
    }
  }
  throw std::out_of_range("no such quantity");
}

}  // namespace sim2sim
