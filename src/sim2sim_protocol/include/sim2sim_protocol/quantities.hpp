// SPDX-License-Identifier: BSD-3-Clause
/// The figures of a rollout, each listed once. Columns of episodes.csv and sweep.csv, keys of metrics.json, messages
/// and tables take names, units and order from here: a new figure is a line in kQuantities, the function that it
/// names, and a raised kDescriptionFormat.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "pusht_task/constants.hpp"
#include "pusht_task/rollout.hpp"

namespace sim2sim {

/// A rollout, and what the reference did in the same episode.
struct RolloutView {
  const pusht::Rollout& rollout;
  const pusht::Trace& reference;
  int reset_every = 0;                   ///< control steps after which it was put to the reference's state; 0: never
  const pusht::Trace* replay = nullptr;  ///< of the engine, for its closed loop
};

// How to compute them. NaN where an episode has none.

/// [m] from the tee's origin to the target, after the last step.
double finalPositionError(const RolloutView& view);
/// [rad] of the tee's yaw from the target's, after the last step; in [0, pi].
double finalAngleError(const RolloutView& view);
/// [m] from the reference's tee, mean over the steps that both have, the start included.
double meanPositionDivergence(const RolloutView& view);
/// [rad] from the reference's yaw, mean over the steps that both have; in [0, pi].
double meanAngleDivergence(const RolloutView& view);
/// The same over the first kEarlySteps: none where a rollout is shorter, so that all episodes count alike.
double earlyPositionDivergence(const RolloutView& view);
double earlyAngleDivergence(const RolloutView& view);
/// The null model's mean divergence over the steps that both have: that of a tee that stays where it started, or where
/// it was last put to the reference's state.
double nullPositionDivergence(const RolloutView& view);
double nullAngleDivergence(const RolloutView& view);
/// Mean of the divergence just before the rollout is put to the reference's state: what `reset_every` control steps
/// make.
double anchorPositionError(const RolloutView& view);
double anchorAngleError(const RolloutView& view);

/// How much less the closed loop diverges than the replay, mean over the steps that both and the reference have: what
/// the policy's feedback removes. Below 0 it adds.
double absorbedPositionDivergence(const RolloutView& view);
double absorbedAngleDivergence(const RolloutView& view);
/// [1/step] How fast the reference amplifies a small difference; growthRate() of a floor, in protocol/parting.hpp.
double growthRateOf(const RolloutView& view);

/// [control steps] The horizon that nearly all episodes have in common: 2 s.
constexpr int kEarlySteps = 20;

/// Which rollouts have a quantity.
enum class Scope {
  kModes,       ///< the modes: what became of the task
  kCompared,    ///< all but the reference itself
  kClosed,      ///< the engine in closed loop
  kStateReset,  ///< those that are put to the reference's state
  kFloor,       ///< the reference from a start that is moved by 1e-6 m
};

/// What is measured of every rollout.
struct Quantity {
  const char* name;   ///< as in messages; with the unit, a column of episodes.csv
  const char* unit;   ///< "m"
  Scope scope;        ///< which rollouts have it
  double least;       ///< that there can be
  double limit;       ///< the largest that there can be
  const char* label;  ///< of its line in the table; nullptr: it has none
  double (*compute)(const RolloutView& view);
  const char* course_key;  ///< in metrics.json, of its mean over the replays; nullptr where the course has none
};

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

inline constexpr std::array kQuantities = {
    Quantity{"final_position_error", "m", Scope::kModes, 0.0, kUnlimited, nullptr, finalPositionError, nullptr},
    Quantity{"final_angle_error", "rad", Scope::kModes, 0.0, pusht::kPi, nullptr, finalAngleError, nullptr},
    Quantity{"mean_position_divergence", "m", Scope::kCompared, 0.0, kUnlimited, "position", meanPositionDivergence,
             "mean_pos_divergence"},
    Quantity{"mean_angle_divergence", "rad", Scope::kCompared, 0.0, pusht::kPi, "angle", meanAngleDivergence,
             "mean_ang_divergence"},
    Quantity{"early_position_divergence", "m", Scope::kCompared, 0.0, kUnlimited, nullptr, earlyPositionDivergence,
             nullptr},
    Quantity{"early_angle_divergence", "rad", Scope::kCompared, 0.0, pusht::kPi, nullptr, earlyAngleDivergence,
             nullptr},
    Quantity{"null_position_divergence", "m", Scope::kCompared, 0.0, kUnlimited, nullptr, nullPositionDivergence,
             nullptr},
    Quantity{"null_angle_divergence", "rad", Scope::kCompared, 0.0, pusht::kPi, nullptr, nullAngleDivergence, nullptr},
    Quantity{"absorbed_position_divergence", "m", Scope::kClosed, -kUnlimited, kUnlimited, nullptr,
             absorbedPositionDivergence, nullptr},
    Quantity{"absorbed_angle_divergence", "rad", Scope::kClosed, -pusht::kPi, pusht::kPi, nullptr,
             absorbedAngleDivergence, nullptr},
    Quantity{"anchor_position_error", "m", Scope::kStateReset, 0.0, kUnlimited, nullptr, anchorPositionError, nullptr},
    Quantity{"anchor_angle_error", "rad", Scope::kStateReset, 0.0, pusht::kPi, nullptr, anchorAngleError, nullptr},
    Quantity{"growth_rate", "per_step", Scope::kFloor, -kUnlimited, kUnlimited, nullptr, growthRateOf, nullptr},
};

/// One number for each of kQuantities; NaN where there is none.
using QuantityValues = std::array<double, kQuantities.size()>;

/// None of them.
constexpr QuantityValues noQuantities() {
  QuantityValues none{};
  for (double& value : none) {
    value = std::numeric_limits<double>::quiet_NaN();
  }
  return none;
}

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
