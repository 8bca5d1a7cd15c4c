// SPDX-License-Identifier: BSD-3-Clause
/// A window onto a table: a rectangle of a picture that shows part of a table, enlarged, and nothing beyond its edges.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "pusht_task/types.hpp"
#include "sim2sim_eval/live/canvas.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Part of a table, parallel to its walls, in the frame of the table [m].
struct Region {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double width = 0.0;
};

/// The rectangle that a window takes in the frame of its canvas [m].
struct Pane {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d size = Eigen::Vector2d::Zero();
};

/// Where things happen in an episode so far: the target, the ways of all tees and pushers near a tee. It never shrinks
/// while the episode goes on, and grows in steps, at most to the whole table.
Region regionOf(const Episode& episode, const Pane& pane);

/// Draws what is at table coordinates [m] into a canvas, clipped to the window.
class TableView {
 public:
  TableView(const Pane& pane, const Region& region);

  /// Magnification: metres of the canvas for each metre of the table.
  double zoom() const { return zoom_; }

  Eigen::Vector2d toCanvas(const Eigen::Vector2d& on_table) const;
  bool shows(const Eigen::Vector2d& on_table) const;

  /// The part of a table's floor and walls that is seen.
  void table(Canvas& canvas, const std_msgs::ColorRGBA& floor, const std_msgs::ColorRGBA& walls) const;

  /// A filled convex polygon at a height.
  void area(Canvas& canvas, const std_msgs::ColorRGBA& color, const std::vector<Eigen::Vector2d>& corners,
            double z) const;

  /// A line through points at a height; `width` in the frame of the canvas [m].
  void line(Canvas& canvas, const std_msgs::ColorRGBA& color, double width, const std::vector<Eigen::Vector2d>& points,
            double z) const;

  /// A way, dim where it begins. `shares`: how much of it lies behind each point, in [0, 1].
  void way(Canvas& canvas, const std_msgs::ColorRGBA& color, double width, const std::vector<Eigen::Vector2d>& points,
           const std::vector<double>& shares, double z) const;

  /// From a point along a vector, as far as the window goes; none from beyond its edges.
  void arrow(Canvas& canvas, const std_msgs::ColorRGBA& color, double width, const Eigen::Vector2d& from,
             const Eigen::Vector2d& along, double z) const;

  /// The tee's shape, filled and with its outline.
  void tee(Canvas& canvas, const std_msgs::ColorRGBA& surface, const std_msgs::ColorRGBA& outline,
           const pusht::WorldState& state, double z) const;

  /// An arrow at the edge, towards what is beyond it; none for what the window shows.
  void edgeMark(Canvas& canvas, const std_msgs::ColorRGBA& color, double size, const Eigen::Vector2d& on_table) const;

 private:
  using Segment = std::array<Eigen::Vector2d, 2>;

  /// The part of a segment, in canvas coordinates, that is seen, as shares of its length; false: none.
  bool clip(const Segment& segment, double& begin, double& end) const;
  void addArea(Points& triangles, const std::vector<Eigen::Vector2d>& corners, double z) const;

  Pane pane_;
  Region region_;
  double zoom_;
};

/// The corners of the tee's stem and of its bar, each convex, on the table [m].
std::array<std::vector<Eigen::Vector2d>, 2> teeCorners(const pusht::WorldState& state);

/// A circle as a closed line [m].
std::vector<Eigen::Vector2d> circleOf(const Eigen::Vector2d& center, double radius);

/// Whether a tee has left the table: its origin is beyond the inner face of a wall.
bool isOffTable(const pusht::WorldState& state);

}  // namespace sim2sim
