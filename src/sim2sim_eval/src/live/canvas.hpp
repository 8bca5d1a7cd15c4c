// SPDX-License-Identifier: BSD-3-Clause
/// Drawing of lines, texts and shapes in one TF frame, as rviz markers.
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
#include "pusht_task/types.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_serving/world_markers.hpp"

namespace sim2sim {

// Colors of the captions of single worlds.
using pusht::kBright;
using pusht::kCard;
using pusht::kDim;
using pusht::kLayer;

// Heights of texts [m].
constexpr double kTitleSize = 0.062;
constexpr double kResultSize = 0.051;
constexpr double kSmallSize = 0.044;

constexpr double kCharacterWidth = 0.46;  // mean width of a character, in heights of the text

constexpr std::array<std::uint32_t, kModeCount> kWorldColors = {pusht::palette::kReference, pusht::palette::kEngine,
                                                                pusht::palette::kReplay};

/// Color of a mode's world in the picture.
std_msgs::ColorRGBA colorOf(Mode mode, float opacity = 1.0F);

// Widths of lines and arrows [m].
constexpr double kMarkWidth = 0.005;  // thin lines that mark something
constexpr double kTrailWidth = 0.007;
constexpr double kCommandWidth = 0.009;
constexpr double kVelocityWidth = 0.012;

constexpr float kGhostOpacity = 0.35F;
constexpr float kTargetOpacity = 0.2F;

// Heights of layers [m]. Each covers those that are listed before it.
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

/// Point as a message [m].
geometry_msgs::Point point(double x, double y, double z);

/// List of markers in one frame. A call always adds one marker: an empty text or line becomes a marker that deletes
/// what its predecessor drew. So two drawings of one kind of picture have the same markers, and the later replaces the
/// earlier.
class Canvas {
 public:
  /// `frame`: TF frame of all positions [m].
  explicit Canvas(std::string frame) : frame_(std::move(frame)) {}

  /// Adds a marker of a type of visualization_msgs/Marker, without a shape.
  visualization_msgs::Marker& add(int type, const std_msgs::ColorRGBA& color);

  /// Adds a line of `width` [m]; `type` is LINE_STRIP or LINE_LIST.
  void line(int type, const std_msgs::ColorRGBA& color, double width, Points points);

  /// Adds a surface; each three corners are a triangle.
  void triangles(const std_msgs::ColorRGBA& color, Points corners);

  /// Adds an arrow from a point along a vector in the plane [m]; empty if the vector is shorter than the arrow's head.
  void arrow(const std_msgs::ColorRGBA& color, double width, const geometry_msgs::Point& from,
             const Eigen::Vector2d& along);

  /// Adds a text of height `size`, centered at x and y [m].
  void text(const std::string& text, double x, double y, double size, const std_msgs::ColorRGBA& color);

  /// Adds a filled rectangle between two corners at the height `z` [m].
  void rectangle(const std_msgs::ColorRGBA& color, double left, double bottom, double right, double top, double z);

  /// Marker that was added last.
  visualization_msgs::Marker& last() { return markers_.back(); }

  /// Appends all markers to `array`, with the namespace `ns` and the ids 0, 1, ...
  void appendTo(visualization_msgs::MarkerArray& array, const std::string& ns);

 private:
  std::string frame_;
  std::vector<visualization_msgs::Marker> markers_;
};

}  // namespace sim2sim
