// SPDX-License-Identifier: BSD-3-Clause
/// What a world looks like in rviz.
#pragma once

#include <geometry_msgs/Point.h>
#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <string>
#include <vector>

namespace pusht {

constexpr double kWallHeight = 0.03;  ///< [m] as drawn; the task is planar

/// A colour as on the web, 0xRRGGBB, and its opacity in [0, 1].
std_msgs::ColorRGBA color(std::uint32_t rgb, float opacity = 1.0F);

struct WorldColors {
  std_msgs::ColorRGBA table = color(0x2B313D);
  std_msgs::ColorRGBA walls = color(0x525B6E);
  std_msgs::ColorRGBA tee = color(0xB9C3D6);
  std_msgs::ColorRGBA pusher = color(0xF4F4F2);
  std_msgs::ColorRGBA target = color(0xF4F4F2);
};

/// A marker at the origin of `frame`. TF moves it, whatever its age: to publish it once, latched, is enough.
visualization_msgs::Marker frameLockedMarker(const std::string& frame, int type, const std_msgs::ColorRGBA& color);

/// Names the markers `ns`/0, `ns`/1, ...
void enumerate(const std::string& ns, std::vector<visualization_msgs::Marker>& markers);

/// The shape of the tee in the xy plane of its frame [m]: for a closed LINE_STRIP, and for a TRIANGLE_LIST.
std::vector<geometry_msgs::Point> teeOutline();
std::vector<geometry_msgs::Point> teeSurface();

/// The geometry of a world in its frames `<frame_prefix>/{table,pusher,tee,target}`; the namespace is the prefix.
visualization_msgs::MarkerArray worldMarkers(const std::string& frame_prefix, const WorldColors& colors = {});

}  // namespace pusht
