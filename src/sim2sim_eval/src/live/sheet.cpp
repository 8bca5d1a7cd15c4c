// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/live/sheet.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace sim2sim {

using pusht::frameLockedMarker;
using std_msgs::ColorRGBA;
using visualization_msgs::Marker;

namespace {

constexpr double kOutlineWidth = 0.005;
constexpr float kBeginning = 0.25F;  // share of the colour where a way begins
constexpr double kHeadWidths = 3.0;  // of an arrow, in widths of its shaft
constexpr double kHeadLengths = 3.0;
constexpr int kCirclePoints = 24;

}  // namespace

ColorRGBA colorOf(Mode mode, float opacity) { return pusht::color(kWorldColors[mode], opacity); }

geometry_msgs::Point point(double x, double y, double z) {
  geometry_msgs::Point point;
  point.x = x;
  point.y = y;
  point.z = z;
  return point;
}

Points circle(double x, double y, double z, double radius) {
  Points points;
  for (int i = 0; i <= kCirclePoints; ++i) {
    const double angle = 2.0 * pusht::kPi * i / kCirclePoints;
    points.push_back(point(x + radius * std::cos(angle), y + radius * std::sin(angle), z));
  }
  return points;
}

Marker& Sheet::add(int type, const ColorRGBA& color) {
  return markers_.emplace_back(frameLockedMarker(frame_, type, color));
}

void Sheet::line(int type, const ColorRGBA& color, double width, Points points) {
  Marker& line = add(type, color);
  line.scale.x = width;
  line.action = points.size() < 2 ? Marker::DELETE : Marker::ADD;
  line.points = std::move(points);
}

void Sheet::way(const ColorRGBA& color, double width, const std::vector<WayPoint>& way_points) {
  Points points;
  std::transform(way_points.begin(), way_points.end(), std::back_inserter(points),
                 [](const WayPoint& way_point) { return way_point.place; });
  line(Marker::LINE_STRIP, color, width, std::move(points));
  Marker& way = markers_.back();
  for (const WayPoint& way_point : way_points) {
    const float share = kBeginning + (1.0F - kBeginning) * static_cast<float>(way_point.time);
    ColorRGBA shade = color;
    shade.r *= share;
    shade.g *= share;
    shade.b *= share;
    way.colors.push_back(shade);
  }
}

void Sheet::arrow(const ColorRGBA& color, double width, const geometry_msgs::Point& from,
                  const Eigen::Vector2d& along) {
  Marker& arrow = add(Marker::ARROW, color);
  arrow.scale.x = width;
  arrow.scale.y = kHeadWidths * width;
  arrow.scale.z = kHeadLengths * width;
  arrow.action = along.norm() > arrow.scale.z ? Marker::ADD : Marker::DELETE;
  arrow.points = {from, point(from.x + along.x(), from.y + along.y(), from.z)};
}

void Sheet::text(const std::string& text, double x, double y, double size, const ColorRGBA& color) {
  Marker& marker = add(Marker::TEXT_VIEW_FACING, color);
  marker.pose.position = point(x, y, kTextZ);
  marker.scale.z = size;
  marker.action = text.empty() ? Marker::DELETE : Marker::ADD;
  marker.text = text;
}

void Sheet::rectangle(const ColorRGBA& color, double left, double bottom, double right, double top, double z) {
  Marker& cube = add(Marker::CUBE, color);
  cube.pose.position = point(0.5 * (left + right), 0.5 * (bottom + top), z);
  cube.scale.x = right - left;
  cube.scale.y = top - bottom;
  cube.scale.z = 0.001;
}

void Sheet::tee(const ColorRGBA& surface, const ColorRGBA& outline, const pusht::WorldState& state, double z) {
  geometry_msgs::Pose pose;
  pose.position = point(state.tee_position.x(), state.tee_position.y(), z);
  pose.orientation.z = std::sin(0.5 * state.tee_yaw);
  pose.orientation.w = std::cos(0.5 * state.tee_yaw);

  Marker& inside = add(Marker::TRIANGLE_LIST, surface);
  inside.pose = pose;
  inside.scale.x = inside.scale.y = inside.scale.z = 1.0;
  inside.points = pusht::teeSurface();
  Marker& edge = add(Marker::LINE_STRIP, outline);
  edge.pose = pose;
  edge.scale.x = kOutlineWidth;
  edge.points = pusht::teeOutline();
}

void Sheet::appendTo(visualization_msgs::MarkerArray& array, const std::string& ns) {
  pusht::enumerate(ns, markers_);
  array.markers.insert(array.markers.end(), markers_.begin(), markers_.end());
}

}  // namespace sim2sim
