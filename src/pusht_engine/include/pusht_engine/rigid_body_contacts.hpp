// SPDX-License-Identifier: BSD-3-Clause
/// Where bodies touch, for one world or many. Vectors in table axes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>

#include "pusht_engine/rigid_body_model.hpp"
#include "pusht_engine/rigid_body_solver.hpp"
#include "pusht_engine/simd.hpp"
#include "pusht_task/constants.hpp"

namespace pusht::rigid_body {

/// Two bodies that touch.
template <class Real>
struct Contact {
  Condition<Real> touching;  ///< elsewhere the rest says nothing
  Vector2<Real> point;       ///< [m] at which forces act
  Vector2<Real> normal;      ///< of length 1, the way in which the contact pushes the first body
  Real depth;                ///< [m] overlap; below 0 inside a margin
};

/// The direction of the tee: body x is (cosine, sine).
template <class Real>
struct Heading {
  Real cosine;
  Real sine;

  Vector2<Real> toTable(const Vector2<Real>& v) const {
    return {cosine * v.x() - sine * v.y(), sine * v.x() + cosine * v.y()};
  }
  Vector2<Real> toBody(const Vector2<Real>& v) const {
    return {cosine * v.x() + sine * v.y(), cosine * v.y() - sine * v.x()};
  }
};

/// A box upright on the table, by its own axes. In the plane the last two say nothing.
struct Box {
  double half_x;       ///< [m]
  double half_y;       ///< [m]
  double half_height;  ///< [m]
  double height;       ///< [m] of its centre
};

/// One of the two boxes of the tee.
struct Part {
  double offset;  ///< [m] from the tee's origin to its centre, along body -y
  Box box;
  double disc_radius;  ///< [m] of the disc that stands for it where shapes are simple

  /// [m] No point of box or disc is farther from its centre.
  constexpr double reach() const { return box.half_x + box.half_y; }
};
constexpr double kTeeHeight = 0.0152;  ///< [m] of its centre, in MuJoCo's scene
constexpr std::array<Part, 2> kParts = {
    Part{0.0, {kBarHalfLength, kTeeHalfWidth, kTeeHalfWidth, kTeeHeight}, simple::kBarRadius},
    Part{kStemOffset, {kTeeHalfWidth, kStemHalfLength, kTeeHalfWidth, kTeeHeight}, simple::kStemRadius}};

template <class Real>
Vector2<Real> centreOf(const Part& part, const Vector2<Real>& tee, const Heading<Real>& heading) {
  return tee + Vector2<Real>(part.offset * heading.sine, -part.offset * heading.cosine);
}

/// A wall, of which the inner face is `side` * kWallInnerFace on its axis.
struct Wall {
  Eigen::Index axis;
  double side;  ///< 1 or -1

  Eigen::Vector2d inward() const { return -side * Eigen::Vector2d::Unit(axis); }
  Eigen::Vector2d centre() const { return -(kWallInnerFace + 0.5 * dynamics::kWallThickness) * inward(); }

  /// Walls cross at the corners of the table.
  Box box() const {
    constexpr double kHalfLength = kWallInnerFace + dynamics::kWallThickness;
    constexpr double kHalfThickness = 0.5 * dynamics::kWallThickness;
    constexpr double kHalfHeight = 0.03;  // [m] in MuJoCo's scene; they stand on the table
    return {axis == 0 ? kHalfThickness : kHalfLength, axis == 0 ? kHalfLength : kHalfThickness, kHalfHeight,
            kHalfHeight};
  }
};
constexpr std::array<Wall, 4> kWalls = {Wall{1, 1.0}, Wall{1, -1.0}, Wall{0, 1.0}, Wall{0, -1.0}};

/// Two discs; pushes the first. (Coincident centres have no normal, and do not touch.)
template <class Real>
Contact<Real> touchDiscs(const Vector2<Real>& first, double first_radius, const Vector2<Real>& second,
                         double second_radius, double margin) {
  using std::sqrt;
  constexpr double kCoincident = 1.0e-12;  // [m]
  const Vector2<Real> apart = first - second;
  const Real distance = sqrt(apart.dot(apart));
  const Condition<Real> known = distance > kCoincident;
  const Real inverse = 1.0 / select(known, distance, Real(1.0));
  const Vector2<Real> normal = scaled<Real>(inverse, apart);
  const Real depth = first_radius + second_radius - distance;
  return {known && depth > -margin, second + scaled<Real>(second_radius - 0.5 * depth, normal), normal, depth};
}

/// A disc and a box of the tee at their nearest points; pushes the box. A centre inside the box is nearest to one of
/// its four faces.
template <class Real>
Contact<Real> touchNearest(const Vector2<Real>& disc, double radius, const Box& box, const Vector2<Real>& box_centre,
                           const Heading<Real>& heading, double margin) {
  using std::sqrt;
  const Vector2<Real> local = heading.toBody(disc - box_centre);
  const auto clamped = [](const Real& value, double limit) {
    return select(value < -limit, Real(-limit), select(value > limit, Real(limit), value));
  };
  const auto magnitude = [](const Real& value) { return select(value < 0.0, -value, value); };
  const auto sign = [](const Real& value) { return select(value < 0.0, Real(-1.0), Real(1.0)); };
  const Real zero(0.0);

  // Outside: from the nearest point of the box to the centre.
  const Vector2<Real> nearest = {clamped(local.x(), box.half_x), clamped(local.y(), box.half_y)};
  const Vector2<Real> apart = local - nearest;
  const Real squared = apart.dot(apart);
  const Condition<Real> outside = squared > 0.0;
  const Real distance = sqrt(squared);
  const Real inverse = 1.0 / select(outside, distance, Real(1.0));

  // Inside: through the nearest face.
  const Real room_x = box.half_x - magnitude(local.x());
  const Real room_y = box.half_y - magnitude(local.y());
  const Condition<Real> through_x = room_x < room_y;

  const Vector2<Real> out = {
      select(outside, apart.x() * inverse, select(through_x, sign(local.x()), zero)),
      select(outside, apart.y() * inverse, select(through_x, zero, sign(local.y()))),
  };
  const Real depth = radius - select(outside, distance, -select(through_x, room_x, room_y));
  const Vector2<Real> normal = -heading.toTable(out);
  return {depth > -margin, disc + scaled<Real>(radius - 0.5 * depth, normal), normal, depth};
}

/// A disc and a wall at their nearest points; pushes the disc.
template <class Real>
Contact<Real> touchWall(const Vector2<Real>& disc, double radius, const Wall& wall, double margin) {
  const Real depth = wall.side * disc[wall.axis] + (radius - kWallInnerFace);
  const Eigen::Vector2d inward = wall.inward();
  const Vector2<Real> normal = {Real(inward.x()), Real(inward.y())};
  return {depth > -margin, disc - scaled<Real>(radius - 0.5 * depth, normal), normal, depth};
}

/// Pusher and box as MuJoCo finds them, with libccd's MPR on a cylinder and a box in space; pushes the box. Where
/// libccd finds no overlap, none. Source: G. Snethen, "XenoCollide: Complex Collision Made Simple" (Game Programming
/// Gems 7, 2008).
Contact<double> touchPortal(const Vector2<double>& pusher, const Box& box, const Vector2<double>& box_centre,
                            const Heading<double>& heading);

/// Replaces a contact of nearest points, which pushes the box, by the portal's. Where libccd finds none, bodies touch
/// only across a margin, at their nearest points.
void refine(const Vector2<double>& pusher, const Box& box, const Vector2<double>& box_centre,
            const Heading<double>& heading, Contact<double>& contact);
void refine(const Vector2<simd::Lanes>& pusher, const Box& box, const Vector2<simd::Lanes>& box_centre,
            const Heading<simd::Lanes>& heading, Contact<simd::Lanes>& contact);

}  // namespace pusht::rigid_body
