// SPDX-License-Identifier: BSD-3-Clause
/// Quantities that are measured of a rollout, each listed once in kQuantities. Columns of episodes.csv and sweep.csv,
/// keys of metrics.json, messages and tables take names, units and order from there. A new quantity is a line in
/// kQuantities, the function that it names, and, if results of before would have it, a raised format of "metrics" in
/// result_files.json.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "pusht_task/constants.hpp"
#include "pusht_task/rollout.hpp"
#include "sim2sim_protocol/pushes.hpp"

namespace sim2sim {

/// A rollout with what is needed to measure it, of the same episode.
struct RolloutView {
  const pusht::Rollout& rollout;
  const pusht::Trace& reference;         ///< trace of the reference in closed loop
  int reset_every = 0;                   ///< [control steps] between resets to the reference's state; 0: none
  const pusht::Trace* replay = nullptr;  ///< trace of the engine in open loop; null for a probe
};

// Quantities as functions. NaN if a rollout has none. Lengths are in the table frame.

/// [m] Distance of the tee's origin from the target after the last step.
double finalPositionError(const RolloutView& view);
/// [rad] Difference of the tee's yaw from the target's after the last step; in [0, pi].
double finalAngleError(const RolloutView& view);
/// [m] Distance from the reference's tee, mean over the steps that both have, the initial state included.
double meanPositionDivergence(const RolloutView& view);
/// [rad] Difference from the reference's yaw, mean over the steps that both have; in [0, pi].
double meanAngleDivergence(const RolloutView& view);
/// [m] Distance from the reference's tee, mean over the initial state and the first kEarlySteps. NaN if this rollout or
/// the reference is shorter, so that all episodes have the same steps.
double earlyPositionDivergence(const RolloutView& view);
/// [rad] Difference from the reference's yaw, over the steps of earlyPositionDivergence(); in [0, pi].
double earlyAngleDivergence(const RolloutView& view);
/// [m] Distance from the reference's tee over the first kFiveSecondSteps; NaN as for earlyPositionDivergence().
double fiveSecondsPositionDivergence(const RolloutView& view);
/// [rad] Difference from the reference's yaw over the first kFiveSecondSteps, likewise; in [0, pi].
double fiveSecondsAngleDivergence(const RolloutView& view);
/// [m] Mean divergence of the null model over the steps that both have: a tee that stays where it started, or where it
/// was last reset to the reference's state.
double nullPositionDivergence(const RolloutView& view);
/// [rad] Mean divergence of the null model's yaw.
double nullAngleDivergence(const RolloutView& view);
/// [m] Mean divergence of the null model over the steps of earlyPositionDivergence().
double earlyNullPositionDivergence(const RolloutView& view);
/// [rad] Mean divergence of the null model's yaw over these steps.
double earlyNullAngleDivergence(const RolloutView& view);
/// [m] Mean divergence of the null model over the steps of fiveSecondsPositionDivergence().
double fiveSecondsNullPositionDivergence(const RolloutView& view);
/// [rad] Mean divergence of the null model's yaw over these steps.
double fiveSecondsNullAngleDivergence(const RolloutView& view);
/// [m] Divergence just before a reset to the reference's state, mean over the resets: the error of `reset_every` steps.
/// It has no interval: a null model at the anchors is not measured, and the one over all steps is too small for it.
double anchorPositionError(const RolloutView& view);
/// [rad] Divergence of the yaw just before a reset, likewise.
double anchorAngleError(const RolloutView& view);

/// [m] Divergence that the policy's feedback removes: replay minus closed loop, mean over the steps that both and the
/// reference have. Below 0 the feedback adds divergence.
double absorbedPositionDivergence(const RolloutView& view);
/// [rad] Divergence of the yaw that the feedback removes, likewise.
double absorbedAngleDivergence(const RolloutView& view);
/// [rad] Angle between the displacements of the reference's and the engine's tee, mean over the pushes of a state-reset
/// replay (pushes.hpp); pi/2 for a missed one. Like the next three it is NaN in an episode without a push.
double pushDirectionError(const RolloutView& view);
/// [-] Share of the pushes that the engine misses: its tee hardly moves.
double pushesMissed(const RolloutView& view);
/// [-] Share of the pushes that are not missed in which the engine's tee moves the other way: by more than pi/2.
double pushesTurned(const RolloutView& view);
/// [-] Natural logarithm of the engine's over the reference's displacement, mean over the pushes.
double pushSize(const RolloutView& view);
/// [-] Largest share of the target that the tee covers at the end of a control step, or at the start.
double largestCoverage(const RolloutView& view);
/// [-] Share of the target that the tee covers after the last step.
double finalCoverage(const RolloutView& view);
/// [-] 1 if more than 0.95 of the target is covered at some time, the success of gym-pusht and Diffusion Policy; else
/// 0.
double coveredAtBest(const RolloutView& view);
/// [-] 1 if more than 0.95 of the target is covered after the last step; else 0.
double coveredAtEnd(const RolloutView& view);
/// [-] 1 if the tee is within 20 mm and 20 degrees of the target at some time, the success of world models; else 0.
/// What these ask of the pusher besides has no meaning in a task that has no place for it.
double withinWorldModels(const RolloutView& view);
/// [1/control step] Growth rate of a small difference in the reference: growthRate() of a floor, with the default
/// bound.
double growthRateOf(const RolloutView& view);

/// [control steps] Horizon that nearly all episodes have in common: 2 s.
constexpr int kEarlySteps = 20;
/// [control steps] Horizon of 5 s, which most episodes have.
constexpr int kFiveSecondSteps = 50;

/// Rollouts that have a quantity.
enum class Scope {
  kModes,       ///< the three modes and closed loops in model variants
  kCompared,    ///< all but the reference itself
  kClosed,      ///< the engine in closed loop
  kStateReset,  ///< state-reset replays
  kPushes,      ///< state-reset replays; results without these have no column of it
  kCoverage,    ///< closed loops of a run with coverage (Protocol::hasCoverage()); others have no column of it
  kFloor,       ///< the reference from an initial state moved by 1e-6 m
};

/// Value of Quantity::null_model where a divergence has a null model that is not measured.
inline constexpr const char* kUnmeasured = "";

/// Description of a quantity.
struct Quantity {
  const char* name;   ///< name in messages; with the unit, a column of episodes.csv
  const char* unit;   ///< "m"
  Scope scope;        ///< rollouts that have it
  double least;       ///< smallest possible value
  double limit;       ///< largest possible value
  const char* label;  ///< heading in the printed table, of a mean over whole episodes; null: none
  double (*compute)(const RolloutView& view);
  const char* course_key;  ///< course's key in metrics.json of the mean over the replays; null: none
  /// Quantity of the null model, a tee that never moves, of which a divergence has the multiple or the difference; its
  /// mean is the `extreme` of the intervals (sim2sim_statistics/tails.hpp). Null: not a divergence.
  const char* null_model = nullptr;

  /// Whether its means and differences may have intervals: not those of a divergence without a measured null model.
  constexpr bool hasIntervals() const { return null_model == nullptr || *null_model != '\0'; }
};

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

inline constexpr std::array kQuantities = {
    Quantity{"final_position_error", "m", Scope::kModes, 0.0, kUnlimited, nullptr, finalPositionError, nullptr},
    Quantity{"final_angle_error", "rad", Scope::kModes, 0.0, pusht::kPi, nullptr, finalAngleError, nullptr},
    Quantity{"mean_position_divergence", "m", Scope::kCompared, 0.0, kUnlimited, "position", meanPositionDivergence,
             "mean_pos_divergence", "null_position_divergence"},
    Quantity{"mean_angle_divergence", "rad", Scope::kCompared, 0.0, pusht::kPi, "angle", meanAngleDivergence,
             "mean_ang_divergence", "null_angle_divergence"},
    Quantity{"early_position_divergence", "m", Scope::kCompared, 0.0, kUnlimited, nullptr, earlyPositionDivergence,
             nullptr, "early_null_position_divergence"},
    Quantity{"early_angle_divergence", "rad", Scope::kCompared, 0.0, pusht::kPi, nullptr, earlyAngleDivergence, nullptr,
             "early_null_angle_divergence"},
    Quantity{"null_position_divergence", "m", Scope::kCompared, 0.0, kUnlimited, nullptr, nullPositionDivergence,
             nullptr},
    Quantity{"null_angle_divergence", "rad", Scope::kCompared, 0.0, pusht::kPi, nullptr, nullAngleDivergence, nullptr},
    Quantity{"absorbed_position_divergence", "m", Scope::kClosed, -kUnlimited, kUnlimited, nullptr,
             absorbedPositionDivergence, nullptr, "null_position_divergence"},
    Quantity{"absorbed_angle_divergence", "rad", Scope::kClosed, -pusht::kPi, pusht::kPi, nullptr,
             absorbedAngleDivergence, nullptr, "null_angle_divergence"},
    Quantity{"anchor_position_error", "m", Scope::kStateReset, 0.0, kUnlimited, nullptr, anchorPositionError, nullptr,
             kUnmeasured},
    Quantity{"anchor_angle_error", "rad", Scope::kStateReset, 0.0, pusht::kPi, nullptr, anchorAngleError, nullptr,
             kUnmeasured},
    Quantity{"growth_rate", "per_step", Scope::kFloor, -kUnlimited, kUnlimited, nullptr, growthRateOf, nullptr},
    Quantity{"early_5s_position_divergence", "m", Scope::kCompared, 0.0, kUnlimited, nullptr,
             fiveSecondsPositionDivergence, nullptr, "early_5s_null_position_divergence"},
    Quantity{"early_5s_angle_divergence", "rad", Scope::kCompared, 0.0, pusht::kPi, nullptr, fiveSecondsAngleDivergence,
             nullptr, "early_5s_null_angle_divergence"},
    Quantity{"early_null_position_divergence", "m", Scope::kCompared, 0.0, kUnlimited, nullptr,
             earlyNullPositionDivergence, nullptr},
    Quantity{"early_null_angle_divergence", "rad", Scope::kCompared, 0.0, pusht::kPi, nullptr, earlyNullAngleDivergence,
             nullptr},
    Quantity{"early_5s_null_position_divergence", "m", Scope::kCompared, 0.0, kUnlimited, nullptr,
             fiveSecondsNullPositionDivergence, nullptr},
    Quantity{"early_5s_null_angle_divergence", "rad", Scope::kCompared, 0.0, pusht::kPi, nullptr,
             fiveSecondsNullAngleDivergence, nullptr},
    Quantity{"push_direction_error", "rad", Scope::kPushes, 0.0, pusht::kPi, nullptr, pushDirectionError, nullptr},
    Quantity{"pushes_missed", "share", Scope::kPushes, 0.0, 1.0, nullptr, pushesMissed, nullptr},
    Quantity{"pushes_turned", "share", Scope::kPushes, 0.0, 1.0, nullptr, pushesTurned, nullptr},
    Quantity{"push_size", "log", Scope::kPushes, -kLargestPushSize, kLargestPushSize, nullptr, pushSize, nullptr},
    Quantity{"largest_coverage", "share", Scope::kCoverage, 0.0, 1.0, nullptr, largestCoverage, nullptr},
    Quantity{"final_coverage", "share", Scope::kCoverage, 0.0, 1.0, nullptr, finalCoverage, nullptr},
    Quantity{"covered_at_best", "share", Scope::kCoverage, 0.0, 1.0, nullptr, coveredAtBest, nullptr},
    Quantity{"covered_at_end", "share", Scope::kCoverage, 0.0, 1.0, nullptr, coveredAtEnd, nullptr},
    Quantity{"within_20mm_20deg", "share", Scope::kCoverage, 0.0, 1.0, nullptr, withinWorldModels, nullptr},
};

/// Value of each of kQuantities, in its unit; NaN if there is none.
using QuantityValues = std::array<double, kQuantities.size()>;

/// Values that are all NaN.
constexpr QuantityValues noQuantities() {
  QuantityValues none{};
  for (double& value : none) {
    value = std::numeric_limits<double>::quiet_NaN();
  }
  return none;
}

/// Index of a quantity in kQuantities. Throws std::out_of_range if there is none of that name.
constexpr std::size_t quantityIndex(std::string_view name) {
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    if (name == kQuantities[i].name) {
      return i;
    }
  }
  throw std::out_of_range("no such quantity");
}

}  // namespace sim2sim
