// SPDX-License-Identifier: BSD-3-Clause
/// View of a table: a rectangle of a canvas that shows part of a table, enlarged and clipped to the rectangle.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "live/canvas.hpp"
#include "pusht_task/task.hpp"
#include "pusht_task/types.hpp"
#include "sim2sim_protocol/episode.hpp"

namespace sim2sim {

/// Part of a table that a view shows, in the frame of the table [m]; its height follows from the pane's aspect ratio.
struct Region {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double width = 0.0;
};

/// Rectangle that a view takes on its canvas, in the canvas's frame [m].
struct Pane {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d size = Eigen::Vector2d::Zero();
};

/// Region in which an episode happens so far: the target, the paths of all tees, and the pushers near a tee. It never
/// shrinks while the episode goes on, and grows in steps of 0.06 m, at most to the whole table.
Region regionOf(const Episode& episode, const Pane& pane);

/// Drawing at table coordinates [m] into a canvas, clipped to the pane. Sizes and widths are in the canvas's frame [m].
class TableView {
 public:
  TableView(const Pane& pane, const Region& region, const pusht::Task& task = pusht::fullCircle());

  /// Magnification: meters of the canvas per meter of the table.
  double zoom() const { return zoom_; }

  /// Canvas coordinates of a point of the table [m].
  Eigen::Vector2d toCanvas(const Eigen::Vector2d& on_table) const;

  /// Whether a point of the table lies in the pane.
  bool shows(const Eigen::Vector2d& on_table) const;

  /// Draws the visible part of the floor and the walls.
  void table(Canvas& canvas, const std_msgs::ColorRGBA& floor, const std_msgs::ColorRGBA& walls) const;

  /// Draws a filled convex polygon at the height `z`.
  void area(Canvas& canvas, const std_msgs::ColorRGBA& color, const std::vector<Eigen::Vector2d>& corners,
            double z) const;

  /// Draws a line through points at the height `z`.
  void line(Canvas& canvas, const std_msgs::ColorRGBA& color, double width, const std::vector<Eigen::Vector2d>& points,
            double z) const;

  /// Draws a path that grows brighter along its way. `shares`: share of its length before each point, in [0, 1].
  void way(Canvas& canvas, const std_msgs::ColorRGBA& color, double width, const std::vector<Eigen::Vector2d>& points,
           const std::vector<double>& shares, double z) const;

  /// Draws an arrow from a point along a vector, cut off at the pane's edge; none from a point outside.
  void arrow(Canvas& canvas, const std_msgs::ColorRGBA& color, double width, const Eigen::Vector2d& from,
             const Eigen::Vector2d& along, double z) const;

  /// Draws the tee, filled and with its outline.
  void tee(Canvas& canvas, const std_msgs::ColorRGBA& surface, const std_msgs::ColorRGBA& outline,
           const pusht::WorldState& state, double z) const;

  /// Draws a mark at the pane's edge that points to `on_table`; none for a point inside.
  void edgeMark(Canvas& canvas, const std_msgs::ColorRGBA& color, double size, const Eigen::Vector2d& on_table) const;

 private:
  using Segment = std::array<Eigen::Vector2d, 2>;

  /// Visible part of a segment in canvas coordinates, as shares of its length; false: none.
  bool clip(const Segment& segment, double& begin, double& end) const;
  void addArea(Points& triangles, const std::vector<Eigen::Vector2d>& corners, double z) const;

  Pane pane_;
  Region region_;
  const pusht::Task& task_;
  double zoom_;
};

/// Corners of bar and stem of a task's tee, each a convex polygon, on the table [m].
std::array<std::vector<Eigen::Vector2d>, 2> teeCorners(const pusht::WorldState& state,
                                                       const pusht::Task& task = pusht::fullCircle());

/// Circle as a closed line [m].
std::vector<Eigen::Vector2d> circleOf(const Eigen::Vector2d& center, double radius);

}  // namespace sim2sim
