// SPDX-License-Identifier: BSD-3-Clause
#include "live/legend.hpp"

#include <array>
#include <vector>

#include "live/table_view.hpp"
#include "pusht_task/constants.hpp"
#include "sim2sim_serving/world_markers.hpp"

namespace sim2sim {

using Eigen::Vector2d;
using pusht::color;

namespace {

constexpr double kColumnWidth = 0.94;  // [m]
constexpr double kRowPitch = 0.070;    // [m]
constexpr double kIconWidth = 0.11;    // [m]

/// View of an icon, which shows `width` of a table [m].
TableView icon(const Vector2d& center, double width) {
  return TableView({center, {kIconWidth, 0.9 * kRowPitch}}, {Vector2d(0.0, -0.04), width});
}

void drawGhost(Canvas& canvas, const Vector2d& center) {
  icon(center, 0.24).tee(canvas, colorOf(kReferenceClosed, kGhostOpacity), colorOf(kReferenceClosed), {}, kGhostZ);
}

void drawTarget(Canvas& canvas, const Vector2d& center) {
  icon(center, 0.24).tee(canvas, color(kBright, kTargetOpacity), color(kBright), {}, kTargetZ);
}

void drawTolerance(Canvas& canvas, const Vector2d& center) {
  const TableView view = icon(center, 0.24);
  view.line(canvas, color(kDim), kMarkWidth, circleOf({0.0, -0.01}, pusht::kPositionTolerance), kMarkZ);
  for (const double side : {-1.0, 1.0}) {
    view.line(canvas, color(kDim), kMarkWidth, {{0.01 * side, -0.045}, {0.024 * side, -0.11}}, kMarkZ);
  }
}

void drawFirstDivergence(Canvas& canvas, const Vector2d& center) {
  const TableView view = icon(center, 0.24);
  view.way(canvas, colorOf(kEngineReplay), kTrailWidth, {{-0.11, -0.07}, {0.0, -0.04}, {0.11, -0.06}}, {0.0, 0.5, 1.0},
           kTrailZ);
  view.line(canvas, colorOf(kEngineReplay), kMarkWidth, circleOf({0.0, -0.04}, 0.03), kMarkZ);
}

void drawCommand(Canvas& canvas, const Vector2d& center) {
  const TableView view = icon(center, 0.24);
  view.area(canvas, color(kBright), circleOf({-0.08, -0.04}, pusht::kPusherRadius), kPusherZ);
  view.arrow(canvas, color(kBright), kCommandWidth, {-0.08, -0.04}, {0.18, 0.02}, kArrowZ);
}

void drawVelocity(Canvas& canvas, const Vector2d& center) {
  const TableView view = icon(center, 0.24);
  view.area(canvas, color(kBright), circleOf({-0.08, -0.04}, pusht::kPusherRadius), kPusherZ);
  view.arrow(canvas, colorOf(kEngineReplay), kVelocityWidth, {-0.08, -0.04}, {0.18, -0.02}, kArrowZ);
}

struct Entry {
  void (*draw)(Canvas& canvas, const Vector2d& center);
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

void drawLegend(Canvas& canvas, const Vector2d& corner, int columns) {
  int index = 0;
  for (const Entry& entry : kEntries) {
    const int row = index / columns;
    const Vector2d at = corner + Vector2d(kColumnWidth * (index % columns), -kRowPitch * row);
    entry.draw(canvas, at + Vector2d(0.5 * kIconWidth, 0.0));
    // A text of rviz has its middle where it is put.
    const double width =
        kCharacterWidth * kSmallSize * static_cast<double>(std::char_traits<char>::length(entry.words));
    canvas.text(entry.words, at.x() + 1.2 * kIconWidth + 0.5 * width, at.y(), kSmallSize, color(kDim));
    ++index;
  }
}

}  // namespace sim2sim
