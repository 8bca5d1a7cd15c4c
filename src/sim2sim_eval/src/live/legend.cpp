// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/live/legend.hpp"

#include <array>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/ros/world_markers.hpp"
#include "sim2sim_eval/live/window.hpp"

namespace sim2sim {

using Eigen::Vector2d;
using pusht::color;

namespace {

constexpr double kColumnWidth = 0.94;  // [m]
constexpr double kRowPitch = 0.070;    // [m]
constexpr double kIconWidth = 0.11;    // [m]

/// A window that is an icon: `width` of a table is seen.
Window icon(const Vector2d& center, double width) {
  return Window({center, {kIconWidth, 0.9 * kRowPitch}}, {Vector2d(0.0, -0.04), width});
}

void drawGhost(Sheet& sheet, const Vector2d& center) {
  icon(center, 0.24).tee(sheet, colorOf(kReferenceClosed, kGhostOpacity), colorOf(kReferenceClosed), {}, kGhostZ);
}

void drawTarget(Sheet& sheet, const Vector2d& center) {
  icon(center, 0.24).tee(sheet, color(kBright, kTargetOpacity), color(kBright), {}, kTargetZ);
}

void drawTolerance(Sheet& sheet, const Vector2d& center) {
  const Window window = icon(center, 0.24);
  window.line(sheet, color(kDim), kMarkWidth, circleOf({0.0, -0.01}, pusht::kPositionTolerance), kMarkZ);
  for (const double side : {-1.0, 1.0}) {
    window.line(sheet, color(kDim), kMarkWidth, {{0.01 * side, -0.045}, {0.024 * side, -0.11}}, kMarkZ);
  }
}

void drawFirstDivergence(Sheet& sheet, const Vector2d& center) {
  const Window window = icon(center, 0.24);
  window.way(sheet, colorOf(kEngineReplay), kTrailWidth, {{-0.11, -0.07}, {0.0, -0.04}, {0.11, -0.06}}, {0.0, 0.5, 1.0},
             kTrailZ);
  window.line(sheet, colorOf(kEngineReplay), kMarkWidth, circleOf({0.0, -0.04}, 0.03), kMarkZ);
}

void drawCommand(Sheet& sheet, const Vector2d& center) {
  const Window window = icon(center, 0.24);
  window.area(sheet, color(kBright), circleOf({-0.08, -0.04}, pusht::kPusherRadius), kPusherZ);
  window.arrow(sheet, color(kBright), kCommandWidth, {-0.08, -0.04}, {0.18, 0.02}, kArrowZ);
}

void drawVelocity(Sheet& sheet, const Vector2d& center) {
  const Window window = icon(center, 0.24);
  window.area(sheet, color(kBright), circleOf({-0.08, -0.04}, pusht::kPusherRadius), kPusherZ);
  window.arrow(sheet, colorOf(kEngineReplay), kVelocityWidth, {-0.08, -0.04}, {0.18, -0.02}, kArrowZ);
}

struct Entry {
  void (*draw)(Sheet& sheet, const Vector2d& center);
  const char* words;
};

constexpr std::array<Entry, 6> kEntries = {{
    {drawGhost, "the reference's tee, now"},
    {drawFirstDivergence, "way of the tee; here they part"},
    {drawCommand, "what the pusher is told"},
    {drawTarget, "the target"},
    {drawTolerance, "near enough for success"},
    {drawVelocity, "how fast the pusher is"},
}};

}  // namespace

void drawLegend(Sheet& sheet, const Vector2d& corner, int columns) {
  int place = 0;
  for (const Entry& entry : kEntries) {
    const int row = place / columns;
    const Vector2d at = corner + Vector2d(kColumnWidth * (place % columns), -kRowPitch * row);
    entry.draw(sheet, at + Vector2d(0.5 * kIconWidth, 0.0));
    // A text of rviz has its middle where it is put.
    const double width = kLetterWidth * kSmallSize * static_cast<double>(std::char_traits<char>::length(entry.words));
    sheet.text(entry.words, at.x() + 1.2 * kIconWidth + 0.5 * width, at.y(), kSmallSize, color(kDim));
    ++place;
  }
}

}  // namespace sim2sim
