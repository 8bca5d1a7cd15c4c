// SPDX-License-Identifier: BSD-3-Clause
/// Markers that show a world in rviz.
#pragma once

#include <geometry_msgs/Point.h>
#include <pusht_msgs/Describe.h>
#include <std_msgs/ColorRGBA.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/palette.hpp"
#include "pusht_task/task.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

constexpr double kWallHeight = 0.03;  ///< [m] as drawn; the task is planar

/// Color as on the web, 0xRRGGBB, and its opacity in [0, 1].
std_msgs::ColorRGBA color(std::uint32_t rgb, float opacity = 1.0F);

/// Colors of the parts of a world in rviz.
struct WorldColors {
  std_msgs::ColorRGBA table = color(palette::kTable);
  std_msgs::ColorRGBA walls = color(palette::kWalls);
  std_msgs::ColorRGBA tee = color(palette::kTee);
  std_msgs::ColorRGBA pusher = color(palette::kInk);
  std_msgs::ColorRGBA target = color(palette::kInk);
};

// The look of texts, and of the cards that they stand on. Cards have the color of rviz's background: a pusher may
// leave the table, and passes below them.
constexpr std::uint32_t kBright = palette::kInk;
constexpr std::uint32_t kDim = palette::kDim;
constexpr std::uint32_t kCard = palette::kPaper;
constexpr double kTitleSize = 0.058;   ///< [m] of texts
constexpr double kResultSize = 0.046;  ///< [m]
constexpr double kSmallSize = 0.040;   ///< [m]

/// Distance between heights of layers [m]. From above, rviz cannot tell apart what is less than 0.006 m over the other
/// (24 bits of depth down to its far plane, 100 km away).
constexpr double kLayer = 0.015;

/// `text`, cut to at most `length` bytes with "..." at its end. UTF-8 characters stay whole.
std::string fitted(const std::string& text, std::size_t length);

/// A marker at the origin of `frame`. TF moves it, whatever its age: to publish it once, latched, is enough.
visualization_msgs::Marker frameLockedMarker(const std::string& frame, int type, const std_msgs::ColorRGBA& color);

/// Names the markers `ns`/0, `ns`/1, ...
void enumerate(const std::string& ns, std::vector<visualization_msgs::Marker>& markers);

/// The shape of the tee in the xy plane of its frame [m]: for a closed LINE_STRIP, and for a TRIANGLE_LIST.
std::vector<geometry_msgs::Point> teeOutline(const Physics& physics = {});
/// Surface of the tee in the xy plane of its frame [m], for a TRIANGLE_LIST.
std::vector<geometry_msgs::Point> teeSurface(const Physics& physics = {});
/// Corners of stem and bar in that plane [m], counterclockwise.
std::array<std::array<geometry_msgs::Point, 4>, 2> teeRectangles(const Physics& physics = {});

/// Static parts: table, walls and target, in the frames `<frame_prefix>/{table,target}`.
visualization_msgs::MarkerArray tableMarkers(const std::string& frame_prefix, const Task& task = fullCircle(),
                                             const WorldColors& colors = {});

/// The geometry of a world in its frames `<frame_prefix>/{table,pusher,tee,target}`; the namespace is the prefix.
visualization_msgs::MarkerArray worldMarkers(const std::string& frame_prefix, const Task& task = fullCircle(),
                                             const WorldColors& colors = {});

/// Texts above and below the table of a simulator that is shown alone.
struct Caption {
  /// Time and state that the caption shows.
  struct Moment {
    std::uint64_t episode = 0;
    std::uint32_t steps = 0;  ///< control steps since the reset
    WorldState state;
  };

  std::string title;
  std::vector<std::string> settings;  ///< the parameters that differ from their defaults, as "block_damp 20.0"
  std::optional<Moment> moment;       ///< none: nothing has been reset yet
  std::reference_wrapper<const Task> task = fullCircle();
};

/// Caption of the simulator with this description, before any episode.
Caption captionOf(const pusht_msgs::DescribeResponse& description);

/// `caption` in the frame `<frame_prefix>/table`, in the namespace `<frame_prefix>/caption`: always the same markers,
/// so that those of one caption replace those of another.
visualization_msgs::MarkerArray captionMarkers(const std::string& frame_prefix, const Caption& caption);

}  // namespace pusht
