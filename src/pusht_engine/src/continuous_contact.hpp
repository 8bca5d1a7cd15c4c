// SPDX-License-Identifier: BSD-3-Clause
/// Continuous contact of the rigid-body engine: bodies that would meet within a substep are slowed so far that they
/// just meet at its end, instead of overlapping or passing through each other. MuJoCo has nothing of this kind.
///
/// Where the motion of a substep, as the other laws have it, takes two bodies deeper into each other than
/// allowedOverlap(), a *speculative contact* limits their approach: along the normal at which they meet, the distance
/// that they close is at most the gap. The pusher's path is swept against the tee's rounded boxes, so bodies that miss
/// each other are left alone, however fast they are. Motions are swept again until none is new: a tee that is hit may
/// be thrown at a wall.
///
/// Head on, a meeting gives nothing back. With `friction` it has the friction of any contact here, MuJoCo's pyramid in
/// the plane, with what comes of that convex cone: bodies that slide past each other part a little. Energy never grows:
/// resting is always allowed, and the result is the nearest allowed motion.
/// Turns are linear first, then corrected until bodies just touch; where a turning tee is wedged between pusher and
/// wall, 0.2 mm may remain.
/// Sources: P. Firth, "Speculative Contacts" (wildbunny, 2011); E. Catto, "Continuous Collision" (GDC 2013); the swept
/// disc: C. Ericson, "Real-Time Collision Detection" (2005), section 5.5.7.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "rigid_body_contacts.hpp"
#include "rigid_body_dynamics.hpp"

namespace pusht::rigid_body {

/// First touch of a disc on a straight path with a box at rest.
struct Hit {
  double distance;         ///< [m] along the normal, from the start to the touch; 0 if they overlap at the start
  Eigen::Vector2d normal;  ///< unit vector from the box to the disc
  Eigen::Vector2d center;  ///< [m] of the disc at the touch
};

/// First touch of a disc of `radius` [m], moved straight from `start` to `end` [m], with the box -half..half [m] around
/// the origin. A disc that overlaps it at the start touches it at once, unless it moves out. No touch: nothing.
std::optional<Hit> sweepDisc(const Eigen::Vector2d& start, const Eigen::Vector2d& end, double radius,
                             const Eigen::Vector2d& half);

/// [m] Overlap that continuous contact leaves to the model's own law of contact: with `softness` the depth at which
/// that is at its full impedance, otherwise none.
double allowedOverlap(const Model& model);

/// The accelerations nearest to `acceleration`, by the inertia of the implicit integrator, that leave no overlap above
/// the allowed one at the end of the substep, or that at least close no gap further.
Vector withoutOverlap(const Model& model, const Matrix& mass, const Bodies& bodies, const Vector& acceleration);

}  // namespace pusht::rigid_body
