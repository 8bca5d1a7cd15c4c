// SPDX-License-Identifier: BSD-3-Clause
/// Contacts in a world state, from its poses and the task's geometry alone. So they are defined equally
/// for every simulator, in process, as a node or from a bag. Frame: table.
/// The task's shapes count also for a simulator with other shapes, as the discs of the two-mass engine. The task's
/// walls count also in a world without walls.
#pragma once

#include <Eigen/Core>

#include "pusht_task/task.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

/// Bodies with a gap of at most this touch. It is as near to 0 as states can be trusted: simulators of single precision
/// exist, and MuJoCo itself finds contacts to 1e-6 m (mpr_tolerance). Soft contacts do not need more: they overlap.
/// Whether pusher and tee touch at the end of a control step agrees with MuJoCo's own list of contacts in 97.2 % of all
/// steps and in 99.98 % of those in which the tee moves by 1 mm (400 episodes of the shipped policy). With 1e-4 m it
/// would in 95.4 and 98.1 %, with 1e-3 m in 90.5 and 92.8 %. Where it does not, the bodies rest side by side.
constexpr double kContactTolerance = 1e-6;  ///< [m]

/// Part of the tee that the pusher touches.
enum class Part {
  kNone,
  kBar,
  kStem,
  kCorner,  ///< bar and stem at once: the pusher sits where they meet
};

/// Intersection of two parts: kBar for kCorner and kBar.
Part common(Part a, Part b);

/// Geometry of the pusher against one box of the tee.
struct Contact {
  double gap = 0.0;                                  ///< [m] between the surfaces; below 0 they overlap
  Eigen::Vector2d point = Eigen::Vector2d::Zero();   ///< [m] point of the box's surface nearest to the pusher
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  ///< unit vector from the box to the pusher
  /// [m/s] of the pusher's surface along the box's, positive to the left of the normal. The pusher does not turn.
  double slip = 0.0;

  bool touches() const { return gap <= kContactTolerance; }
};

/// Geometry of the pusher against both boxes of the tee.
struct Contacts {
  Contact bar;
  Contact stem;

  Part part() const;
};
/// Contacts of the pusher with both boxes of the tee.
Contacts contactsOf(const WorldState& state, const Task& task = fullCircle());

/// Distance that the pusher's surface slides along `part`, kBar or kStem, which it touches before and after [m].
/// Positive to the left of the normal. A tee that rolls along the pusher does not slide. It is computed from poses
/// alone, because velocities are of an instant, and some simulators have none. Throws InternalError for another part.
///
/// The point of contact moves by c along the box's outline and by -r dphi along the pusher's, of radius r, where dphi
/// is what the normal turns in the table's frame. They slide by the difference, c + r dphi.
/// Source: the contact equations of D. J. Montana, "The Kinematics of Contact and Grasp" (1988), in the plane.
double slipDistance(const WorldState& before, const WorldState& after, Part part, const Task& task = fullCircle());

/// Gap between a body and the nearest wall's inner face [m]; below 0: beyond it.
struct WallGaps {
  double pusher = 0.0;
  double tee = 0.0;

  bool touches() const { return pusher <= kContactTolerance || tee <= kContactTolerance; }
};
/// Distances of pusher and tee from the nearest wall [m].
WallGaps wallGapsOf(const WorldState& state, const Task& task = fullCircle());

}  // namespace pusht
