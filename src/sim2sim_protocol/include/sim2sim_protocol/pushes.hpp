// SPDX-License-Identifier: BSD-3-Clause
/// Pushes: windows of a few control steps in which the reference's tee moves, and what the engine makes of them from
/// the same state with the same actions. The definitions are those of docs/study/noise/plan.md ("Which error of a
/// simulator costs success?"); sim2sim_study/pushes.py has them for any engine, a test there holds the two equal.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "pusht_task/constants.hpp"
#include "pusht_task/rollout.hpp"

namespace sim2sim {

/// [m] Radius of gyration of full_circle's tee about its center of mass, for yaw in the norm of a displacement;
/// rounded, as the study's plan fixes it. In other tasks it is the tee's.
constexpr double kGyration = 0.044;
/// [m/control step] A window is a push if the reference's tee moves by more than this, times the window's steps.
constexpr double kLeastPush = 0.0004;
/// [-] Share of the reference's displacement below which the engine misses a push.
constexpr double kMissedShare = 0.25;
/// [rad] Direction error of a missed push.
constexpr double kMissedDirection = 0.5 * pusht::kPi;
/// [-] Largest ratio of displacements, either way, in the mean logarithm; and its natural logarithm.
constexpr double kLargestPushRatio = 20.0;
constexpr double kLargestPushSize = 2.995732273553991;

/// Displacement [m] of a tee from state `a` to state `b`: x and y of the center of mass in the table frame, and the
/// yaw, wrapped, times the radius of gyration. Its norm is how far the tee's points move, root mean square by mass.
Eigen::Vector3d teeDisplacement(const pusht::WorldState& a, const pusht::WorldState& b,
                                const pusht::Task& task = pusht::fullCircle());

/// Figures over the pushes of an episode; NaN where no push has one.
struct PushFigures {
  int pushes = 0;                                                     ///< windows in which the reference's tee moves
  double direction_error = std::numeric_limits<double>::quiet_NaN();  ///< [rad] mean angle between the displacements
  double missed = std::numeric_limits<double>::quiet_NaN();  ///< [-] share in which the engine's tee hardly moves
  double turned = std::numeric_limits<double>::quiet_NaN();  ///< [-] share of the others with an angle above pi/2
  double size = std::numeric_limits<double>::quiet_NaN();    ///< [-] mean logarithm of engine's over reference's
};

/// Figures over the windows of `window` >= 1 control steps that begin at its multiples. `replay` is the state-reset
/// replay of `reference` with that window. Where its tee succeeds within a window, the engine's displacement ends.
PushFigures pushFigures(const pusht::Trace& reference, const pusht::Trace& replay, int window,
                        const pusht::Task& task = pusht::fullCircle());

}  // namespace sim2sim
