// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/ros/world_markers.hpp"

#include <Eigen/Core>

#include "pusht_task/constants.hpp"

namespace pusht {

using Eigen::Vector3d;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

namespace {

// Seen only. The bodies stand at height 0, so that the height of a frame is half a body's. From above, rviz cannot tell
// apart what is less than 0.006 m over the other (24 bits of depth down to its far plane, 100 km away).
constexpr double kTableThickness = 0.01;       // [m]
constexpr double kTableHeight = -0.03;         // [m] of its top
constexpr double kTargetHeight = -0.015;       // [m]
constexpr double kWallThickness = 0.04;        // [m]
constexpr double kTargetLineWidth = 0.004;     // [m]
constexpr float kTargetSurfaceOpacity = 0.2F;  // of its line's

geometry_msgs::Point point(double x, double y) {
  geometry_msgs::Point point;
  point.x = x;
  point.y = y;
  return point;
}

/// A box or cylinder of `size` [m] around `center` [m].
Marker body(const std::string& frame, int type, const std_msgs::ColorRGBA& color, const Vector3d& center,
            const Vector3d& size) {
  Marker marker = frameLockedMarker(frame, type, color);
  marker.pose.position.x = center.x();
  marker.pose.position.y = center.y();
  marker.pose.position.z = center.z();
  marker.scale.x = size.x();
  marker.scale.y = size.y();
  marker.scale.z = size.z();
  return marker;
}

Marker targetOutline(const std::string& frame, const std_msgs::ColorRGBA& color) {
  Marker marker = frameLockedMarker(frame, Marker::LINE_STRIP, color);
  marker.pose.position.z = kTargetHeight;
  marker.scale.x = kTargetLineWidth;
  marker.points = teeOutline();
  return marker;
}

Marker targetSurface(const std::string& frame, std_msgs::ColorRGBA color) {
  color.a *= kTargetSurfaceOpacity;
  Marker marker = frameLockedMarker(frame, Marker::TRIANGLE_LIST, color);
  marker.pose.position.z = kTargetHeight;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.points = teeSurface();
  return marker;
}

}  // namespace

std_msgs::ColorRGBA color(std::uint32_t rgb, float opacity) {
  const auto channel = [rgb](int shift) { return static_cast<float>((rgb >> shift) & 0xFFU) / 255.0F; };
  std_msgs::ColorRGBA color;
  color.r = channel(16);
  color.g = channel(8);
  color.b = channel(0);
  color.a = opacity;
  return color;
}

Marker frameLockedMarker(const std::string& frame, int type, const std_msgs::ColorRGBA& color) {
  Marker marker;
  marker.header.frame_id = frame;
  marker.frame_locked = 1;
  marker.type = type;
  marker.pose.orientation.w = 1.0;
  marker.color = color;
  return marker;
}

void enumerate(const std::string& ns, std::vector<Marker>& markers) {
  int id = 0;
  for (Marker& marker : markers) {
    marker.ns = ns;
    marker.id = id++;
  }
}

std::vector<geometry_msgs::Point> teeOutline() {
  constexpr double kStemEnd = -kStemOffset - kStemHalfLength;
  return {point(-kTeeHalfWidth, kStemEnd),        point(kTeeHalfWidth, kStemEnd),
          point(kTeeHalfWidth, -kTeeHalfWidth),   point(kBarHalfLength, -kTeeHalfWidth),
          point(kBarHalfLength, kTeeHalfWidth),   point(-kBarHalfLength, kTeeHalfWidth),
          point(-kBarHalfLength, -kTeeHalfWidth), point(-kTeeHalfWidth, -kTeeHalfWidth),
          point(-kTeeHalfWidth, kStemEnd)};
}

std::vector<geometry_msgs::Point> teeSurface() {
  const std::vector<geometry_msgs::Point> corners = teeOutline();
  std::vector<geometry_msgs::Point> triangles;
  for (const int corner : {0, 1, 2, 0, 2, 7, 6, 3, 4, 6, 4, 5}) {
    triangles.push_back(corners.at(static_cast<std::size_t>(corner)));
  }
  return triangles;
}

MarkerArray worldMarkers(const std::string& frame_prefix, const WorldColors& colors) {
  const std::string table = frame_prefix + "/table";
  const std::string pusher = frame_prefix + "/pusher";
  const std::string tee = frame_prefix + "/tee";
  const std::string target = frame_prefix + "/target";

  constexpr double kInner = 2.0 * kWallInnerFace;
  constexpr double kOuter = kInner + 2.0 * kWallThickness;
  constexpr double kWall = kWallInnerFace + 0.5 * kWallThickness;
  constexpr double kPusherDiameter = 2.0 * kPusherRadius;
  constexpr double kTeeWidth = 2.0 * kTeeHalfWidth;

  MarkerArray world;
  world.markers = {
      body(table, Marker::CUBE, colors.table, {0.0, 0.0, kTableHeight - 0.5 * kTableThickness},
           {kInner, kInner, kTableThickness}),
      body(table, Marker::CUBE, colors.walls, {0.0, kWall, 0.5 * kWallHeight}, {kOuter, kWallThickness, kWallHeight}),
      body(table, Marker::CUBE, colors.walls, {0.0, -kWall, 0.5 * kWallHeight}, {kOuter, kWallThickness, kWallHeight}),
      body(table, Marker::CUBE, colors.walls, {kWall, 0.0, 0.5 * kWallHeight}, {kWallThickness, kInner, kWallHeight}),
      body(table, Marker::CUBE, colors.walls, {-kWall, 0.0, 0.5 * kWallHeight}, {kWallThickness, kInner, kWallHeight}),
      body(tee, Marker::CUBE, colors.tee, Vector3d::Zero(), {2.0 * kBarHalfLength, kTeeWidth, 2.0 * kTeeFrameHeight}),
      body(tee, Marker::CUBE, colors.tee, {0.0, -kStemOffset, 0.0},
           {kTeeWidth, 2.0 * kStemHalfLength, 2.0 * kTeeFrameHeight}),
      body(pusher, Marker::CYLINDER, colors.pusher, Vector3d::Zero(),
           {kPusherDiameter, kPusherDiameter, 2.0 * kPusherFrameHeight}),
      targetSurface(target, colors.target),
      targetOutline(target, colors.target),
  };
  enumerate(frame_prefix, world.markers);
  return world;
}

}  // namespace pusht
