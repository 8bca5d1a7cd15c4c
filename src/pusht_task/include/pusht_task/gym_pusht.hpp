// SPDX-License-Identifier: BSD-3-Clause
/// gym-pusht's PushT (LeRobot; the environment of Diffusion Policy) as far as it is no physics: its units and frame,
/// its draws, its target, its reward. With 1 px = 1 mm tee and pusher have this suite's sizes.
/// Source: gym-pusht 0.1.5.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "pusht_task/coverage.hpp"
#include "pusht_task/types.hpp"

namespace pusht::gym_pusht {

constexpr double kSide = 512.0;             ///< [px] of the window
constexpr double kPixelsPerMeter = 1000.0;  ///< [px/m]
constexpr double kCenterOfGravity = 45.0;   ///< [px] from the tee's origin, as gym-pusht has it; truly 40.714
constexpr double kSuccessCoverage = 0.95;   ///< [-] above it an episode ends in success

/// State in gym-pusht's units and frame: pixels from the upper left corner, y down; the tee's origin is the middle of
/// the bar's outer edge, angles turn clockwise as they are seen.
struct State {
  Eigen::Vector2d pusher = Eigen::Vector2d::Zero();           ///< [px]
  Eigen::Vector2d pusher_velocity = Eigen::Vector2d::Zero();  ///< [px/s]
  Eigen::Vector2d tee = Eigen::Vector2d::Zero();              ///< [px] of its origin
  double angle = 0.0;                                         ///< [rad] as it has been turned: not wrapped
  Eigen::Vector2d tee_velocity = Eigen::Vector2d::Zero();     ///< [px/s] of its center of gravity
  double rate = 0.0;                                          ///< [rad/s]
};

/// State in the table's frame, whose origin is the window's middle. The angle is wrapped. The center of gravity is so
/// many px from the tee's origin.
WorldState toTable(const State& state, double center_of_gravity = kCenterOfGravity);

/// State of the table in gym-pusht's frame. fromTable(toTable(s)) is s to 1e-12 px and the turns of its angle.
State fromTable(const WorldState& state, double center_of_gravity = kCenterOfGravity);

/// What gym-pusht draws for an episode, as its `reset(seed=...)` up to 0.1.5 does, and then asks its world to be in.
/// Bodies may overlap.
State drawn(std::uint32_t seed);

/// Target pose in the table's frame: origin in the window's middle, angle pi/4.
Pose target();

/// [-] Share of the target that the tee covers.
double coverage(const WorldState& state);

/// Reward of a control step that ends with this coverage.
double reward(double coverage);

}  // namespace pusht::gym_pusht
