// SPDX-License-Identifier: BSD-3-Clause
#include "live/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace sim2sim {

using pusht::frameLockedMarker;
using std_msgs::ColorRGBA;
using visualization_msgs::Marker;

namespace {

constexpr double kHeadWidths = 3.0;  // of an arrow, in widths of its shaft
constexpr double kHeadLengths = 3.0;

}  // namespace

ColorRGBA colorOf(Mode mode, float opacity) { return pusht::color(kWorldColors[mode], opacity); }

geometry_msgs::Point point(double x, double y, double z) {
  geometry_msgs::Point point;
  point.x = x;
  point.y = y;
  point.z = z;
  return point;
}

Marker& Canvas::add(int type, const ColorRGBA& color) {
  return markers_.emplace_back(frameLockedMarker(frame_, type, color));
}

void Canvas::line(int type, const ColorRGBA& color, double width, Points points) {
  Marker& line = add(type, color);
  line.scale.x = width;
  line.action = points.size() < 2 ? Marker::DELETE : Marker::ADD;
  line.points = std::move(points);
}

void Canvas::triangles(const ColorRGBA& color, Points corners) {
  Marker& surface = add(Marker::TRIANGLE_LIST, color);
  surface.scale.x = surface.scale.y = surface.scale.z = 1.0;
  surface.action = corners.empty() ? Marker::DELETE : Marker::ADD;
  surface.points = std::move(corners);
}

void Canvas::arrow(const ColorRGBA& color, double width, const geometry_msgs::Point& from,
                   const Eigen::Vector2d& along) {
  Marker& arrow = add(Marker::ARROW, color);
  arrow.scale.x = width;
  arrow.scale.y = kHeadWidths * width;
  arrow.scale.z = kHeadLengths * width;
  arrow.action = along.norm() > arrow.scale.z ? Marker::ADD : Marker::DELETE;
  arrow.points = {from, point(from.x + along.x(), from.y + along.y(), from.z)};
}

void Canvas::text(const std::string& text, double x, double y, double size, const ColorRGBA& color) {
  Marker& marker = add(Marker::TEXT_VIEW_FACING, color);
  marker.pose.position = point(x, y, kTextZ);
  marker.scale.z = size;
  marker.action = text.empty() ? Marker::DELETE : Marker::ADD;
  marker.text = text;
}

void Canvas::rectangle(const ColorRGBA& color, double left, double bottom, double right, double top, double z) {
  Marker& cube = add(Marker::CUBE, color);
  cube.pose.position = point(0.5 * (left + right), 0.5 * (bottom + top), z);
  cube.scale.x = right - left;
  cube.scale.y = top - bottom;
  cube.scale.z = 0.001;
}

void Canvas::appendTo(visualization_msgs::MarkerArray& array, const std::string& ns) {
  pusht::enumerate(ns, markers_);
  array.markers.insert(array.markers.end(), markers_.begin(), markers_.end());
}

}  // namespace sim2sim
