// SPDX-License-Identifier: BSD-3-Clause
/// What a picture is made of: lines, texts and shapes in one frame, as markers.
#pragma once

#include <geometry_msgs/Point.h>
#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/ros/world_markers.hpp"
#include "pusht_task/types.hpp"
#include "sim2sim_eval/protocol/protocol.hpp"

namespace sim2sim {

// As in the captions of single worlds.
using pusht::kBright;
using pusht::kCard;
using pusht::kDim;
using pusht::kLayer;
using pusht::kResultSize;
using pusht::kSmallSize;
using pusht::kTitleSize;

// Three colours that stay far apart in all common colour-vision deficiencies, on a dark background; the same in
// reports.
constexpr std::array<std::uint32_t, kModeCount> kWorldColors = {0x5AAAFF, 0xF0DC46, 0xEE6677};
constexpr std::uint32_t kAxis = 0x7A8496;
constexpr std::uint32_t kGrid = 0x3A4150;
constexpr std::uint32_t kPaper = 0x1F242E;

std_msgs::ColorRGBA colorOf(Mode mode, float opacity = 1.0F);

constexpr double kHeadlineSize = 0.05;  // [m]

constexpr double kMarkWidth = 0.004;  // [m] of thin lines that mark something

// What covers what: heights above the table [m].
constexpr double kTrailZ = 0.0;
constexpr double kGhostZ = 2.0 * pusht::kTeeFrameHeight + kLayer;
constexpr double kMarkZ = kGhostZ + kLayer;
constexpr double kEdgeZ = pusht::kWallHeight + kLayer;
constexpr double kArrowZ = 2.0 * pusht::kPusherFrameHeight + kLayer;
constexpr double kCardZ = kArrowZ + 2.0 * kLayer;  // an engine's pusher may leave the table, and passes below it
constexpr double kPaperZ = kCardZ + kLayer;
constexpr double kGridZ = kPaperZ + kLayer;
constexpr double kAxisZ = kGridZ + kLayer;
constexpr double kCurveZ = kAxisZ + kLayer;
constexpr double kTextZ = kCurveZ + kLayer;

using Points = std::vector<geometry_msgs::Point>;

geometry_msgs::Point point(double x, double y, double z);

/// A point of a way, and when somebody was there: a share of the time since the start, in [0, 1].
struct WayPoint {
  geometry_msgs::Point place;
  double time;
};

/// The points of a circle, closed [m].
Points circle(double x, double y, double z, double radius);

/// What is drawn in one frame. A thing that is not there, as a text without letters, is deleted where it was drawn
/// before: so each drawing of the same kind of picture has the same markers.
class Sheet {
 public:
  /// `frame`: of all positions [m].
  explicit Sheet(std::string frame) : frame_(std::move(frame)) {}

  visualization_msgs::Marker& add(int type, const std_msgs::ColorRGBA& color);

  /// LINE_STRIP or LINE_LIST.
  void line(int type, const std_msgs::ColorRGBA& color, double width, Points points);

  /// A way that somebody took: dim where it begins.
  void way(const std_msgs::ColorRGBA& color, double width, const std::vector<WayPoint>& way_points);

  /// From a point along a vector in the plane; none if it is shorter than its head.
  void arrow(const std_msgs::ColorRGBA& color, double width, const geometry_msgs::Point& from,
             const Eigen::Vector2d& along);

  void text(const std::string& text, double x, double y, double size, const std_msgs::ColorRGBA& color);

  /// A rectangle from corner to corner at a height.
  void rectangle(const std_msgs::ColorRGBA& color, double left, double bottom, double right, double top, double z);

  /// The tee's shape at the pose of `state`, filled and with its outline.
  void tee(const std_msgs::ColorRGBA& surface, const std_msgs::ColorRGBA& outline, const pusht::WorldState& state,
           double z);

  /// Adds all to `array`, named `ns`/0, `ns`/1, ...
  void appendTo(visualization_msgs::MarkerArray& array, const std::string& ns);

 private:
  std::string frame_;
  std::vector<visualization_msgs::Marker> markers_;
};

}  // namespace sim2sim
