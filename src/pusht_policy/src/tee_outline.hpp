// SPDX-License-Identifier: BSD-3-Clause
/// Tee as an obstacle and as something to push, in its own frame: origin in the bar's center, stem along -y.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "pusht_task/mapping.hpp"
#include "pusht_task/physics.hpp"

namespace pusht {

/// Point of the tee's outline, and the way into the tee there.
struct OutlinePoint {
  Eigen::Vector2d point;   ///< [m]
  Eigen::Vector2d inward;  ///< [-] unit normal
};

/// Outline of the tee, and the room that a pusher has around it.
class TeeOutline {
 public:
  explicit TeeOutline(const Physics& physics);

  /// Point after a share of the outline's length, from a corner of the bar on; shares that differ by 1 are the same.
  OutlinePoint at(double share) const;

  /// [m] Distance between the tee and a pusher whose center is at `point`; negative where they overlap.
  double gap(const Eigen::Vector2d& point) const;

  /// Nearest corners [m] of a shortest way for the pusher's center from a point to another, both included, with the
  /// `clearance` [m] as least gap (Dijkstra's algorithm on a visibility graph). A pusher that begins nearer first backs
  /// off. Corners are used where `allowed` is true. Empty if there is no way.
  std::vector<Eigen::Vector2d> wayAround(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double clearance,
                                         const std::function<bool(const Eigen::Vector2d&)>& allowed) const;

 private:
  std::vector<Eigen::Vector2d> cornersOfWays(double clearance) const;
  Eigen::Vector2d backedOff(Eigen::Vector2d point, double clearance) const;
  bool isFree(const Eigen::Vector2d& begin, const Eigen::Vector2d& end, double clearance) const;

  std::array<PlacedBox, 2> boxes_;
  double pusher_radius_;                    // [m]
  std::array<Eigen::Vector2d, 8> corners_;  // [m] counterclockwise
};

}  // namespace pusht
