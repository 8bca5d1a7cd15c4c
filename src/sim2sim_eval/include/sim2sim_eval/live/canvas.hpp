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
#include "pusht_task/palette.hpp"
#include "pusht_task/ros/world_markers.hpp"
#include "pusht_task/types.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

// Colours as in the captions of single worlds.
using pusht::kBright;
using pusht::kCard;
using pusht::kDim;
using pusht::kLayer;

// Heights of texts [m].
constexpr double kTitleSize = 0.062;
constexpr double kResultSize = 0.051;
constexpr double kSmallSize = 0.044;

constexpr double kCharacterWidth = 0.46;  // mean width of a letter, in heights of the text

constexpr std::array<std::uint32_t, kModeCount> kWorldColors = {pusht::palette::kReference, pusht::palette::kEngine,
                                                                pusht::palette::kReplay};

std_msgs::ColorRGBA colorOf(Mode mode, float opacity = 1.0F);

// Widths of lines and arrows [m].
constexpr double kMarkWidth = 0.005;  // of thin lines that mark something
constexpr double kTrailWidth = 0.007;
constexpr double kCommandWidth = 0.009;
constexpr double kVelocityWidth = 0.012;

constexpr float kGhostOpacity = 0.35F;
constexpr float kTargetOpacity = 0.2F;

// Heights [m]: each thing covers those that stand before it here.
constexpr double kFloorZ = -2.0 * kLayer;
constexpr double kTargetZ = -kLayer;
constexpr double kTrailZ = 0.0;
constexpr double kTeeZ = kLayer;
constexpr double kGhostZ = 2.0 * kLayer;
constexpr double kMarkZ = 3.0 * kLayer;
constexpr double kPusherZ = 4.0 * kLayer;
constexpr double kArrowZ = 5.0 * kLayer;
constexpr double kEdgeZ = 7.0 * kLayer;  // an arrow has half a layer more
constexpr double kBandZ = 8.0 * kLayer;
constexpr double kTextZ = 9.0 * kLayer;

using Points = std::vector<geometry_msgs::Point>;

geometry_msgs::Point point(double x, double y, double z);

/// What is drawn in one frame. A thing that is not there, as a text without letters, is deleted where it was drawn
/// before: so each drawing of the same kind of picture has the same markers.
class Canvas {
 public:
  /// `frame`: of all positions [m].
  explicit Canvas(std::string frame) : frame_(std::move(frame)) {}

  visualization_msgs::Marker& add(int type, const std_msgs::ColorRGBA& color);

  /// LINE_STRIP or LINE_LIST.
  void line(int type, const std_msgs::ColorRGBA& color, double width, Points points);

  /// A surface: each three points are a triangle.
  void triangles(const std_msgs::ColorRGBA& color, Points corners);

  /// From a point along a vector in the plane; none if it is shorter than its head.
  void arrow(const std_msgs::ColorRGBA& color, double width, const geometry_msgs::Point& from,
             const Eigen::Vector2d& along);

  void text(const std::string& text, double x, double y, double size, const std_msgs::ColorRGBA& color);

  /// A rectangle from corner to corner at a height.
  void rectangle(const std_msgs::ColorRGBA& color, double left, double bottom, double right, double top, double z);

  /// The marker that was added last.
  visualization_msgs::Marker& last() { return markers_.back(); }

  /// Adds all to `array`, named `ns`/0, `ns`/1, ...
  void appendTo(visualization_msgs::MarkerArray& array, const std::string& ns);

 private:
  std::string frame_;
  std::vector<visualization_msgs::Marker> markers_;
};

}  // namespace sim2sim
