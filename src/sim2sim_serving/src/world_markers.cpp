// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/world_markers.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>

#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace pusht {

using Eigen::Vector3d;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

namespace {

// Seen only. The bodies stand at height 0, so that the height of a frame is half a body's.
constexpr double kTableThickness = 0.01;       // [m]
constexpr double kTableHeight = -0.03;         // [m] of its top
constexpr double kTargetHeight = -0.015;       // [m]
constexpr double kWallThickness = 0.04;        // [m]
constexpr double kTargetLineWidth = 0.004;     // [m]
constexpr float kTargetSurfaceOpacity = 0.2F;  // of its line's

// The caption, in the frame of the table, whose walls end at +-kWallEnd; with other walls it moves with them.
constexpr double kWallEnd = kWallInnerFace + kWallThickness;
constexpr double kCardHeight = 2.0 * kPusherFrameHeight + kLayer;  // [m]
constexpr double kTextHeight = kCardHeight + kLayer;               // [m]
constexpr double kTitleY = 0.485;                                  // [m]
constexpr double kTimeY = -0.475;                                  // [m]
constexpr double kPoseY = -0.525;                                  // [m]
constexpr double kErrorY = -0.570;                                 // [m]
constexpr std::array<double, 2> kSettingsY = {-0.620, -0.665};     // [m] of each line
constexpr double kCardWidth = 1.80;                                // [m]
constexpr std::size_t kLineLength = 105;  // letters of small text that fit beside each other on a card

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

Marker targetOutline(const std::string& frame, const std_msgs::ColorRGBA& color, const Physics& physics) {
  Marker marker = frameLockedMarker(frame, Marker::LINE_STRIP, color);
  marker.pose.position.z = kTargetHeight;
  marker.scale.x = kTargetLineWidth;
  marker.points = teeOutline(physics);
  return marker;
}

Marker targetSurface(const std::string& frame, std_msgs::ColorRGBA color, const Physics& physics) {
  color.a *= kTargetSurfaceOpacity;
  Marker marker = frameLockedMarker(frame, Marker::TRIANGLE_LIST, color);
  marker.pose.position.z = kTargetHeight;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.points = teeSurface(physics);
  return marker;
}

/// A text that stands where it was drawn before is deleted if it has no letters.
Marker text(const std::string& frame, const std::string& text, double y, double size, std::uint32_t rgb) {
  Marker marker = body(frame, Marker::TEXT_VIEW_FACING, color(rgb), {0.0, y, kTextHeight}, {0.0, 0.0, size});
  marker.action = text.empty() ? Marker::DELETE : Marker::ADD;
  marker.text = text;
  return marker;
}

Marker card(const std::string& frame, double bottom, double top) {
  constexpr double kThickness = 0.001;  // [m]
  return body(frame, Marker::CUBE, color(kCard), {0.0, 0.5 * (bottom + top), kCardHeight - 0.5 * kThickness},
              {kCardWidth, top - bottom, kThickness});
}

/// The lines that say what is not as by default, as many as there is room for.
std::array<std::string, kSettingsY.size()> linesOf(const std::vector<std::string>& settings) {
  std::array<std::string, kSettingsY.size()> lines = {settings.empty() ? "as shipped" : ""};
  auto line = lines.begin();
  for (const std::string& setting : settings) {
    const bool last = line == lines.end() - 1;
    if (!last && !line->empty() && line->size() + setting.size() > kLineLength - 3) {
      *line += ",";
      ++line;
    }
    *line += (line->empty() ? "" : ", ") + setting;
  }
  std::transform(lines.begin(), lines.end(), lines.begin(),
                 [](const std::string& line) { return fitted(line, kLineLength); });
  return lines;
}

}  // namespace

std::string fitted(const std::string& text, std::size_t length) {
  const std::string dots = "...";
  if (text.size() <= length) {
    return text;
  }
  const auto inside = [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; };  // of a letter
  std::size_t end = length - dots.size();
  while (end > 0 && inside(text[end])) {
    --end;
  }
  return text.substr(0, end) + dots;
}

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

std::vector<geometry_msgs::Point> teeOutline(const Physics& physics) {
  const double stem_end = -physics.stem_offset - physics.stem_half_length;
  const double stem = physics.stem_half_width;
  const double length = physics.bar_half_length;
  const double width = physics.bar_half_width;
  return {point(-stem, stem_end), point(stem, stem_end), point(stem, -width),
          point(length, -width),  point(length, width),  point(-length, width),
          point(-length, -width), point(-stem, -width),  point(-stem, stem_end)};
}

std::vector<geometry_msgs::Point> teeSurface(const Physics& physics) {
  std::vector<geometry_msgs::Point> triangles;
  for (const auto& [a, b, c, d] : teeRectangles(physics)) {
    triangles.insert(triangles.end(), {a, b, c, a, c, d});
  }
  return triangles;
}

std::array<std::array<geometry_msgs::Point, 4>, 2> teeRectangles(const Physics& physics) {
  const std::vector<geometry_msgs::Point> outline = teeOutline(physics);
  return {{{outline[0], outline[1], outline[2], outline[7]}, {outline[6], outline[3], outline[4], outline[5]}}};
}

MarkerArray tableMarkers(const std::string& frame_prefix, const Task& task, const WorldColors& colors) {
  const std::string table = frame_prefix + "/table";
  const std::string target = frame_prefix + "/target";

  const Physics& physics = task.physics;
  const auto [x, y] = physics.wall_middle;
  const double inner = 2.0 * physics.wall_inner_face;
  const double outer = inner + 2.0 * kWallThickness;
  const double wall = physics.wall_inner_face + 0.5 * kWallThickness;

  MarkerArray world;
  world.markers = {
      body(table, Marker::CUBE, colors.table, {x, y, kTableHeight - 0.5 * kTableThickness},
           {inner, inner, kTableThickness}),
      body(table, Marker::CUBE, colors.walls, {x, y + wall, 0.5 * kWallHeight}, {outer, kWallThickness, kWallHeight}),
      body(table, Marker::CUBE, colors.walls, {x, y - wall, 0.5 * kWallHeight}, {outer, kWallThickness, kWallHeight}),
      body(table, Marker::CUBE, colors.walls, {x + wall, y, 0.5 * kWallHeight}, {kWallThickness, inner, kWallHeight}),
      body(table, Marker::CUBE, colors.walls, {x - wall, y, 0.5 * kWallHeight}, {kWallThickness, inner, kWallHeight}),
      targetSurface(target, colors.target, physics),
      targetOutline(target, colors.target, physics),
  };
  enumerate(frame_prefix, world.markers);
  return world;
}

MarkerArray worldMarkers(const std::string& frame_prefix, const Task& task, const WorldColors& colors) {
  const std::string pusher = frame_prefix + "/pusher";
  const std::string tee = frame_prefix + "/tee";
  const Physics& physics = task.physics;
  const double pusher_diameter = 2.0 * physics.pusher_radius;
  constexpr double kHeight = 2.0 * kTeeFrameHeight;

  MarkerArray world = tableMarkers(frame_prefix, task, colors);
  for (const Marker& marker : {body(tee, Marker::CUBE, colors.tee, Vector3d::Zero(),
                                    {2.0 * physics.bar_half_length, 2.0 * physics.bar_half_width, kHeight}),
                               body(tee, Marker::CUBE, colors.tee, {0.0, -physics.stem_offset, 0.0},
                                    {2.0 * physics.stem_half_width, 2.0 * physics.stem_half_length, kHeight}),
                               body(pusher, Marker::CYLINDER, colors.pusher, Vector3d::Zero(),
                                    {pusher_diameter, pusher_diameter, 2.0 * kPusherFrameHeight})}) {
    world.markers.push_back(marker);
  }
  enumerate(frame_prefix, world.markers);
  return world;
}

Caption captionOf(const pusht_msgs::DescribeResponse& description) {
  Caption caption;
  caption.title = description.title.empty() ? description.name : description.title;
  const auto& known = description.parameter_descriptors;
  if (const std::optional<std::string> task = taskIn(description.parameters)) {
    caption.task = taskNamed(*task);
    caption.settings.push_back("task " + caption.task.get().name);
  }
  for (const pusht_msgs::Parameter& parameter : withoutTask(description.parameters)) {
    const bool is_default = std::any_of(known.begin(), known.end(), [&](const auto& descriptor) {
      return descriptor.name == parameter.name && descriptor.default_value == parameter.value;
    });
    if (!is_default) {
      caption.settings.push_back(parameter.name + " " + parameter.value);
    }
  }
  return caption;
}

MarkerArray captionMarkers(const std::string& frame_prefix, const Caption& caption) {
  std::string time = "waits for a reset";
  std::string pose;
  std::string off_target;
  if (caption.moment) {
    const auto& [episode, steps, state] = *caption.moment;
    time = "episode " + std::to_string(episode) + ", " + fixedText(steps * kControlStep, 1) + " s";
    pose = "tee at x " + fixedText(state.tee_position.x(), 3) + " m, y " + fixedText(state.tee_position.y(), 3) +
           " m, yaw " + fixedText(state.tee_yaw, 2) + " rad";
    const Task& task = caption.task;
    off_target = distanceText(state, task) + (task.success.coverage ? " of the target" : " target");
  }

  constexpr double kMargin = 0.02;  // [m]
  const std::string table = frame_prefix + "/table";
  const Physics& physics = caption.task.get().physics;
  const double up = physics.wall_inner_face + kWallThickness - kWallEnd;  // [m] that the walls end farther out
  MarkerArray markers;
  markers.markers = {
      card(table, kWallEnd + up + 0.5 * kMargin, kTitleY + up + 0.5 * kTitleSize + kMargin),
      card(table, kSettingsY.back() - up - 0.5 * kSmallSize - kMargin, -kWallEnd - up - 0.5 * kMargin),
      text(table, caption.title, kTitleY + up, kTitleSize, kBright),
      text(table, time, kTimeY - up, kResultSize, kBright),
      text(table, pose, kPoseY - up, kSmallSize, kDim),
      text(table, off_target, kErrorY - up, kSmallSize, kDim),
  };
  const auto lines = linesOf(caption.settings);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    markers.markers.push_back(text(table, lines.at(i), kSettingsY.at(i) - up, kSmallSize, kDim));
  }
  enumerate(frame_prefix + "/caption", markers.markers);
  return markers;
}

}  // namespace pusht
