// SPDX-License-Identifier: BSD-3-Clause
#include "tee_outline.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace pusht {
namespace {

using Eigen::Vector2d;

constexpr double kCheckedEvery = 0.003;   // [m] along a way
constexpr double kBackStep = 0.002;       // [m] of a pusher that backs off
constexpr int kMostBackSteps = 60;        // a pusher in the middle of the tee is out after half of them
constexpr double kSlopeStep = 1e-5;       // [m] of the numerical derivative of the gap
constexpr double kCornerMargin = 0.001;   // [m] of corners beyond the clearance, so that ways along edges are free
constexpr double kPriceOfACorner = 0.02;  // [m] of way that a turn costs
constexpr double kLeastShareOfGap = 0.9;  // of the clearance, on a way: its ends keep all of it
constexpr double kUnreached = std::numeric_limits<double>::infinity();

/// [m] From the box; negative inside.
double distanceFrom(const PlacedBox& box, const Vector2d& point) {
  const Vector2d beyond(std::abs(point.x() - box.x) - box.half_x, std::abs(point.y() - box.y) - box.half_y);
  return beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0);
}

std::array<Vector2d, 8> cornersOf(const std::array<PlacedBox, 2>& boxes) {
  const auto& [bar, stem] = boxes;
  const double below_bar = bar.y - bar.half_y;
  const double below_stem = stem.y - stem.half_y;
  return {Vector2d(bar.half_x, bar.y + bar.half_y),
          {-bar.half_x, bar.y + bar.half_y},
          {-bar.half_x, below_bar},
          {-stem.half_x, below_bar},
          {-stem.half_x, below_stem},
          {stem.half_x, below_stem},
          {stem.half_x, below_bar},
          {bar.half_x, below_bar}};
}

/// Node of a visibility graph.
struct Node {
  Vector2d point;
  double way = kUnreached;  // [m] from the first node
  std::size_t before = 0;   // node on the shortest way
  bool settled = false;
};

/// Index of the nearest node that is reached and not settled; their number if there is none.
std::size_t nearestOpen(const std::vector<Node>& nodes) {
  std::size_t nearest = nodes.size();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!nodes[i].settled && nodes[i].way < (nearest < nodes.size() ? nodes[nearest].way : kUnreached)) {
      nearest = i;
    }
  }
  return nearest;
}

/// Points of the way from the first node to the last.
std::vector<Vector2d> wayTo(std::size_t last, const std::vector<Node>& nodes) {
  std::vector<Vector2d> way = {nodes[last].point};
  while (last != 0) {
    last = nodes[last].before;
    way.push_back(nodes[last].point);
  }
  std::reverse(way.begin(), way.end());
  return way;
}

}  // namespace

TeeOutline::TeeOutline(const Physics& physics)
    : boxes_(teeBoxes(physics)), pusher_radius_(physics.pusher_radius), corners_(cornersOf(boxes_)) {}

OutlinePoint TeeOutline::at(double share) const {
  const auto side = [&](std::size_t i) -> Vector2d { return corners_[(i + 1) % corners_.size()] - corners_[i]; };
  double length = 0.0;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    length += side(i).norm();
  }
  double along = (share - std::floor(share)) * length;
  std::size_t i = 0;
  while (i + 1 < corners_.size() && along > side(i).norm()) {
    along -= side(i).norm();
    ++i;
  }
  const Vector2d direction = side(i).normalized();
  return {corners_[i] + along * direction, {-direction.y(), direction.x()}};
}

double TeeOutline::gap(const Vector2d& point) const {
  return std::min(distanceFrom(boxes_[0], point), distanceFrom(boxes_[1], point)) - pusher_radius_;
}

std::vector<Vector2d> TeeOutline::wayAround(const Vector2d& from, const Vector2d& to, double clearance,
                                            const std::function<bool(const Vector2d&)>& allowed) const {
  const double least_gap = kLeastShareOfGap * clearance;
  constexpr std::size_t kGoal = 1;
  std::vector<Node> nodes = {{backedOff(from, clearance), 0.0}, {to}};
  for (const Vector2d& corner : cornersOfWays(clearance)) {
    if (allowed(corner)) {
      nodes.push_back({corner});
    }
  }
  for (std::size_t here = 0; !nodes[kGoal].settled; here = nearestOpen(nodes)) {
    if (here == nodes.size()) {
      return {};
    }
    nodes[here].settled = true;
    for (Node& next : nodes) {
      const double way = nodes[here].way + (next.point - nodes[here].point).norm() + kPriceOfACorner;
      if (way < next.way && isFree(nodes[here].point, next.point, least_gap)) {
        next.way = way;
        next.before = here;
      }
    }
  }
  std::vector<Vector2d> way = wayTo(kGoal, nodes);
  way.insert(way.begin(), from);
  return way;
}

std::vector<Vector2d> TeeOutline::cornersOfWays(double clearance) const {
  const double outward = pusher_radius_ + clearance + kCornerMargin;
  std::vector<Vector2d> corners;
  for (const Vector2d& corner : corners_) {
    for (const Vector2d& diagonal : {Vector2d(-1.0, -1.0), {-1.0, 1.0}, {1.0, -1.0}, {1.0, 1.0}}) {
      if (const Vector2d point = corner + outward * diagonal; gap(point) >= clearance) {
        corners.push_back(point);
      }
    }
  }
  return corners;
}

Vector2d TeeOutline::backedOff(Vector2d point, double clearance) const {
  const auto slope = [&](const Vector2d& step) { return gap(point + step) - gap(point - step); };
  for (int i = 0; i < kMostBackSteps && gap(point) < clearance; ++i) {
    const Vector2d steepest(slope({kSlopeStep, 0.0}), slope({0.0, kSlopeStep}));
    point += kBackStep * (steepest.norm() > 0.0 ? Vector2d(steepest.normalized()) : Vector2d::UnitX());
  }
  return point;
}

bool TeeOutline::isFree(const Vector2d& begin, const Vector2d& end, double clearance) const {
  const int steps = 1 + static_cast<int>((end - begin).norm() / kCheckedEvery);
  for (int i = 0; i <= steps; ++i) {
    if (gap(begin + static_cast<double>(i) / steps * (end - begin)) < clearance) {
      return false;
    }
  }
  return true;
}

}  // namespace pusht
