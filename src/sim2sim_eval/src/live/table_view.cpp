// SPDX-License-Identifier: BSD-3-Clause
#include "live/table_view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

#include "pusht_task/constants.hpp"
#include "sim2sim_serving/world_markers.hpp"

namespace sim2sim {

using Eigen::Vector2d;
using std_msgs::ColorRGBA;
using visualization_msgs::Marker;

namespace {

constexpr double kBeyondWalls = 0.06;  // [m] from the walls' faces to the end of what may be seen
constexpr double kLeastWidth = 0.46;   // [m] of a region: less would magnify what is near the target out of measure
constexpr double kGrid = 0.06;    // [m] to which the edges of a region are rounded outwards, so that it grows seldom
constexpr double kMargin = 0.01;  // [m] around what is to be seen
constexpr double kNear = 0.15;    // [m] from the origin of its tee: a pusher is part of what happens
constexpr double kOutlineWidth = 0.006;
constexpr float kBeginning = 0.25F;  // share of the color where a way begins
constexpr int kCirclePoints = 24;

Vector2d middleOf(const pusht::Task& task) { return {task.physics.wall_middle[0], task.physics.wall_middle[1]}; }

/// [m] From the middle to the end of what may be seen of a task's table.
double tableEnd(const pusht::Task& task) { return task.physics.wall_inner_face + kBeyondWalls; }

/// The smallest rectangle around points, none of which counts as further out than the walls.
class Bounds {
 public:
  explicit Bounds(const pusht::Task& task)
      : task_(task),
        least_(middleOf(task).array() - tableEnd(task)),
        most_(middleOf(task).array() + tableEnd(task)),
        low_(task.target.position),
        high_(task.target.position) {}

  void add(const Vector2d& point) {
    const Vector2d inside = point.cwiseMax(least_).cwiseMin(most_);
    low_ = low_.cwiseMin(inside);
    high_ = high_.cwiseMax(inside);
  }

  void addTee(const pusht::WorldState& state) {
    for (const std::vector<Vector2d>& part : teeCorners(state, task_)) {
      std::for_each(part.begin(), part.end(), [this](const Vector2d& corner) { add(corner); });
    }
  }

  Vector2d low() const { return kGrid * ((low_.array() - kMargin) / kGrid).floor(); }
  Vector2d high() const { return kGrid * ((high_.array() + kMargin) / kGrid).ceil(); }

 private:
  const pusht::Task& task_;
  Vector2d least_;
  Vector2d most_;
  Vector2d low_;
  Vector2d high_;
};

std::vector<Vector2d> rectangle(const Vector2d& low, const Vector2d& high) {
  return {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
}

/// A point of the tee's frame, on the table.
Vector2d onTable(const pusht::WorldState& state, const geometry_msgs::Point& in_tee) {
  return state.tee_position + Eigen::Rotation2D<double>(state.tee_yaw) * Vector2d(in_tee.x, in_tee.y);
}

}  // namespace

Region regionOf(const Episode& episode, const Pane& pane) {
  const pusht::Task& task = episode.rollout(kReferenceClosed).task();
  const double table_end = tableEnd(task);
  Bounds bounds(task);
  bounds.addTee(stateAtTarget(task));
  for (const Mode mode : kModes) {
    for (const pusht::WorldState& state : episode.rollout(mode).trace().states) {
      bounds.addTee(state);
      if ((state.pusher_position - state.tee_position).norm() < kNear) {
        bounds.add(state.pusher_position);
      }
    }
  }
  const double aspect = pane.size.y() / pane.size.x();
  const Vector2d extent = bounds.high() - bounds.low();
  const double width = std::clamp(std::max(extent.x(), extent.y() / aspect), kLeastWidth, 2.0 * table_end);
  // No more of what is beyond the walls than must be.
  const Vector2d reach = (table_end - 0.5 * width * Eigen::Array2d(1.0, aspect)).max(0.0);
  const Vector2d middle = 0.5 * (bounds.low() + bounds.high()) - middleOf(task);
  return {middleOf(task) + middle.cwiseMax(-reach).cwiseMin(reach), width};
}

TableView::TableView(const Pane& pane, const Region& region, const pusht::Task& task)
    : pane_(pane), region_(region), task_(task), zoom_(pane.size.x() / region.width) {}

Vector2d TableView::toCanvas(const Vector2d& on_table) const {
  return pane_.center + zoom_ * (on_table - region_.center);
}

bool TableView::shows(const Vector2d& on_table) const {
  const Vector2d away = (toCanvas(on_table) - pane_.center).cwiseAbs();
  return away.x() <= 0.5 * pane_.size.x() && away.y() <= 0.5 * pane_.size.y();
}

/// Liang and Barsky, "A New Concept and Method for Line Clipping" (1984).
bool TableView::clip(const Segment& segment, double& begin, double& end) const {
  begin = 0.0;
  end = 1.0;
  const Vector2d along = segment[1] - segment[0];
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const double outwards = side * along[axis];
      const double room = 0.5 * pane_.size[axis] - side * (segment[0][axis] - pane_.center[axis]);
      if (outwards == 0.0) {
        if (room < 0.0) {
          return false;
        }
      } else if (outwards < 0.0) {
        begin = std::max(begin, room / outwards);
      } else {
        end = std::min(end, room / outwards);
      }
    }
  }
  return begin < end;
}

/// Sutherland and Hodgman, "Reentrant Polygon Clipping" (1974), then a fan of triangles.
void TableView::addArea(Points& triangles, const std::vector<Vector2d>& corners, double z) const {
  std::vector<Vector2d> kept;
  std::transform(corners.begin(), corners.end(), std::back_inserter(kept),
                 [this](const Vector2d& corner) { return toCanvas(corner); });
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const auto room = [&](const Vector2d& at) {
        return 0.5 * pane_.size[axis] - side * (at[axis] - pane_.center[axis]);
      };
      const std::vector<Vector2d> before = std::exchange(kept, {});
      for (std::size_t i = 0; i < before.size(); ++i) {
        const Vector2d& from = before[i];
        const Vector2d& to = before[(i + 1) % before.size()];
        if (room(from) >= 0.0) {
          kept.push_back(from);
        }
        if ((room(from) < 0.0) != (room(to) < 0.0)) {
          kept.emplace_back(from + room(from) / (room(from) - room(to)) * (to - from));
        }
      }
    }
  }
  for (std::size_t i = 2; i < kept.size(); ++i) {
    for (const Vector2d& corner : {kept[0], kept[i - 1], kept[i]}) {
      triangles.push_back(point(corner.x(), corner.y(), z));
    }
  }
}

void TableView::area(Canvas& canvas, const ColorRGBA& color, const std::vector<Vector2d>& corners, double z) const {
  Points triangles;
  addArea(triangles, corners, z);
  canvas.triangles(color, std::move(triangles));
}

void TableView::table(Canvas& canvas, const ColorRGBA& floor, const ColorRGBA& walls) const {
  const double inner = task_.physics.wall_inner_face;
  const double outer = inner + pusht::dynamics::kWallThickness;
  const auto around = [&](const Vector2d& low, const Vector2d& high) {
    return rectangle(middleOf(task_) + low, middleOf(task_) + high);
  };
  area(canvas, floor, around({-inner, -inner}, {inner, inner}), kFloorZ);
  Points triangles;
  for (const double side : {-1.0, 1.0}) {
    const double near = std::min(side * inner, side * outer);
    const double far = std::max(side * inner, side * outer);
    addArea(triangles, around({-outer, near}, {outer, far}), kFloorZ);
    addArea(triangles, around({near, -inner}, {far, inner}), kFloorZ);
  }
  canvas.triangles(walls, std::move(triangles));
}

void TableView::line(Canvas& canvas, const ColorRGBA& color, double width, const std::vector<Vector2d>& points,
                     double z) const {
  way(canvas, color, width, points, std::vector<double>(points.size(), 1.0), z);
  canvas.last().colors.clear();
}

void TableView::way(Canvas& canvas, const ColorRGBA& color, double width, const std::vector<Vector2d>& points,
                    const std::vector<double>& shares, double z) const {
  Points ends;
  std::vector<ColorRGBA> shades;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Segment segment = {toCanvas(points[i - 1]), toCanvas(points[i])};
    double begin = 0.0;
    double end = 0.0;
    if (!clip(segment, begin, end)) {
      continue;
    }
    for (const double share : {begin, end}) {
      const Vector2d at = segment[0] + share * (segment[1] - segment[0]);
      ends.push_back(point(at.x(), at.y(), z));
      const double behind = shares[i - 1] + share * (shares[i] - shares[i - 1]);
      const float strength = kBeginning + (1.0F - kBeginning) * static_cast<float>(behind);
      ColorRGBA shade = color;
      shade.r *= strength;
      shade.g *= strength;
      shade.b *= strength;
      shades.push_back(shade);
    }
  }
  canvas.line(Marker::LINE_LIST, color, width, std::move(ends));
  canvas.last().colors = std::move(shades);
}

void TableView::arrow(Canvas& canvas, const ColorRGBA& color, double width, const Vector2d& from, const Vector2d& along,
                      double z) const {
  const Segment segment = {toCanvas(from), toCanvas(from + along)};
  double begin = 0.0;
  double end = 0.0;
  const bool seen = shows(from) && clip(segment, begin, end);
  const Vector2d length = seen ? Vector2d(end * (segment[1] - segment[0])) : Vector2d::Zero();
  canvas.arrow(color, width, point(segment[0].x(), segment[0].y(), z), length);
}

void TableView::tee(Canvas& canvas, const ColorRGBA& surface, const ColorRGBA& outline, const pusht::WorldState& state,
                    double z) const {
  Points triangles;
  for (const std::vector<Vector2d>& part : teeCorners(state, task_)) {
    addArea(triangles, part, z);
  }
  canvas.triangles(surface, std::move(triangles));
  std::vector<Vector2d> edge;
  for (const geometry_msgs::Point& corner : pusht::teeOutline(task_.physics)) {
    edge.push_back(onTable(state, corner));
  }
  line(canvas, outline, kOutlineWidth, edge, z);
}

void TableView::edgeMark(Canvas& canvas, const ColorRGBA& color, double size, const Vector2d& on_table) const {
  Points triangle;
  if (!shows(on_table)) {
    const Vector2d away = toCanvas(on_table) - pane_.center;
    const Vector2d room = 0.5 * pane_.size - Vector2d::Constant(size);
    const Vector2d at = pane_.center + away * std::min({room.x() / std::max(std::abs(away.x()), 1e-9),
                                                        room.y() / std::max(std::abs(away.y()), 1e-9)});
    const Vector2d ahead = size * away.normalized();
    const Vector2d aside(-0.7 * ahead.y(), 0.7 * ahead.x());
    for (const Vector2d& corner : {Vector2d(at + ahead), Vector2d(at + aside), Vector2d(at - aside)}) {
      triangle.push_back(point(corner.x(), corner.y(), kEdgeZ));
    }
  }
  canvas.triangles(color, std::move(triangle));
}

std::array<std::vector<Vector2d>, 2> teeCorners(const pusht::WorldState& state, const pusht::Task& task) {
  const auto rectangles = pusht::teeRectangles(task.physics);
  std::array<std::vector<Vector2d>, 2> parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    std::transform(rectangles[i].begin(), rectangles[i].end(), std::back_inserter(parts[i]),
                   [&](const geometry_msgs::Point& corner) { return onTable(state, corner); });
  }
  return parts;
}

std::vector<Vector2d> circleOf(const Vector2d& center, double radius) {
  std::vector<Vector2d> points;
  for (int i = 0; i <= kCirclePoints; ++i) {
    const double angle = 2.0 * pusht::kPi * i / kCirclePoints;
    points.emplace_back(center + radius * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

}  // namespace sim2sim
