// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/coverage.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "pusht_task/mapping.hpp"

namespace pusht {
namespace {

using Eigen::Vector2d;

/// Convex polygon, counterclockwise. Clipping a box by the four sides of another leaves at most eight vertices;
/// rounding may add some where edges coincide.
struct Polygon {
  std::array<Vector2d, 16> vertices;
  std::size_t size = 0;

  void add(const Vector2d& vertex) { vertices.at(size++) = vertex; }
  const Vector2d& after(std::size_t i) const { return vertices[(i + 1) % size]; }
};

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

Polygon polygonOf(const PlacedBox& box, const Pose& pose) {
  const Eigen::Rotation2Dd rotation(pose.yaw);
  Polygon polygon;
  for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}) {
    polygon.add(pose.position + rotation * Vector2d(box.x + x * box.half_x, box.y + y * box.half_y));
  }
  return polygon;
}

/// Area by the shoelace formula, from the first vertex, so that no digits are lost far from the origin.
double areaOf(const Polygon& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size; ++i) {
    twice += cross(polygon.vertices[i] - polygon.vertices[0], polygon.after(i) - polygon.vertices[0]);
  }
  return 0.5 * twice;
}

/// Part of a polygon to the left of the line from `a` to `b` (Sutherland and Hodgman, "Reentrant Polygon Clipping",
/// 1974).
Polygon leftOf(const Vector2d& a, const Vector2d& b, const Polygon& polygon) {
  Polygon left;
  for (std::size_t i = 0; i < polygon.size; ++i) {
    const Vector2d& here = polygon.vertices[i];
    const Vector2d& next = polygon.after(i);
    const double here_side = cross(b - a, here - a);
    const double next_side = cross(b - a, next - a);
    if (here_side >= 0.0) {
      left.add(here);
    }
    if ((here_side > 0.0 && next_side < 0.0) || (here_side < 0.0 && next_side > 0.0)) {
      left.add(here + here_side / (here_side - next_side) * (next - here));
    }
  }
  return left;
}

double areaOfOverlap(const Polygon& one, const Polygon& other) {
  Polygon overlap = one;
  for (std::size_t i = 0; i < other.size && overlap.size > 0; ++i) {
    overlap = leftOf(other.vertices[i], other.after(i), overlap);
  }
  return areaOf(overlap);
}

}  // namespace

double coverageOf(const Pose& tee, const Pose& target, const Physics& physics) {
  double covered = 0.0;
  double whole = 0.0;
  for (const PlacedBox& goal_box : teeBoxes(physics)) {
    const Polygon goal = polygonOf(goal_box, target);
    whole += areaOf(goal);
    for (const PlacedBox& tee_box : teeBoxes(physics)) {
      covered += areaOfOverlap(polygonOf(tee_box, tee), goal);
    }
  }
  return std::clamp(covered / whole, 0.0, 1.0);
}

}  // namespace pusht
