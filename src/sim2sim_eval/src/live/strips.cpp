// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/live/strips.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_eval/protocol/divergence.hpp"

namespace sim2sim {

using pusht::color;
using pusht::fixedText;
using visualization_msgs::Marker;

namespace {

constexpr double kAxisLeft = -0.34;
constexpr double kAxisRight = 0.43;
constexpr double kAxisHeight = 0.13;
constexpr double kTickLabelX = kAxisLeft - 0.04;
constexpr double kTickLabelBelow = 0.028;
constexpr double kTitleX = -0.15;
constexpr double kTitleAbove = 0.03;
constexpr double kValueX = 0.385;  // of the rightmost curve's value; those of others are left of it
constexpr double kValuePitch = 0.135;

constexpr double kThinLine = 0.002;
constexpr double kCurveWidth = 0.006;

constexpr std::size_t kMaxCurvePoints = 75;                                  // about: bounds the size of an update
constexpr std::array<int, 4> kTimeScales = {40, 100, 200, pusht::kHorizon};  // [control steps] full width of the axes

/// A diagram of one component of the divergence against time.
struct Strip {
  const char* title;
  double Divergence::*component;
  double bottom;      // [m] of the axes, in the frame of the table
  double full_scale;  // of the component, at the top of the axes; beyond, a curve runs along the top
  double tick;
  int tick_digits;
};
constexpr std::array<Strip, 2> kStrips = {{
    {"position divergence [m]", &Divergence::position, -0.71, 0.3, 0.1, 1},
    {"angle divergence [rad]", &Divergence::angle, -0.925, pusht::kPi, 1.0, 0},
}};

double heightIn(const Strip& strip, double value) {
  return strip.bottom + kAxisHeight * std::min(value / strip.full_scale, 1.0);
}

/// The points that a long curve is drawn with: its ends, and the highest of each stretch, so that no peak is lost.
Points peaksOf(const Points& curve) {
  if (curve.size() <= kMaxCurvePoints) {
    return curve;
  }
  Points kept = {curve.front()};
  const auto stride = static_cast<std::ptrdiff_t>(curve.size() / kMaxCurvePoints + 1);
  for (auto first = curve.begin() + 1; first != curve.end();) {
    const auto last = first + std::min(stride, curve.end() - first);
    kept.push_back(*std::max_element(first, last, [](const auto& a, const auto& b) { return a.y < b.y; }));
    first = last;
  }
  if (kept.back().x < curve.back().x) {
    kept.push_back(curve.back());
  }
  return kept;
}

double xAt(int step, int time_scale) { return kAxisLeft + (kAxisRight - kAxisLeft) * step / time_scale; }

Points curveOf(const std::vector<Divergence>& steps, const Strip& strip, int time_scale) {
  Points curve;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const double x = xAt(static_cast<int>(k), time_scale);
    curve.push_back(point(x, heightIn(strip, steps[k].*strip.component), kCurveZ));
  }
  return curve;
}

/// The full width of the time axes [control steps].
int timeScale(int steps) {
  return *std::find_if(kTimeScales.begin(), kTimeScales.end() - 1, [steps](int scale) { return steps <= scale; });
}

void drawAxes(Sheet& sheet, const Strip& strip) {
  const double top = strip.bottom + kAxisHeight;
  sheet.rectangle(color(kPaper), kAxisLeft, strip.bottom, kAxisRight, top, kPaperZ);

  Points grid;
  for (int i = 0; i * strip.tick < (1.0 + 1e-9) * strip.full_scale; ++i) {
    const double y = heightIn(strip, i * strip.tick);
    grid.push_back(point(kAxisLeft, y, kGridZ));
    grid.push_back(point(kAxisRight, y, kGridZ));
    sheet.text(fixedText(i * strip.tick, strip.tick_digits), kTickLabelX, y, kSmallSize, color(kDim));
  }
  sheet.line(Marker::LINE_LIST, color(kGrid), kThinLine, std::move(grid));
  sheet.line(
      Marker::LINE_STRIP, color(kAxis), kThinLine,
      {point(kAxisLeft, top, kAxisZ), point(kAxisLeft, strip.bottom, kAxisZ), point(kAxisRight, strip.bottom, kAxisZ)});
  sheet.text(strip.title, kTitleX, top + kTitleAbove, kSmallSize, color(kDim));
}

void drawTimeLabels(Sheet& sheet, int time_scale) {
  const double y = kStrips.back().bottom - kTickLabelBelow;
  const double seconds = time_scale * pusht::kControlStep;
  sheet.text("0", kAxisLeft, y, kSmallSize, color(kDim));
  sheet.text(fixedText(0.5 * seconds, 0), 0.5 * (kAxisLeft + kAxisRight), y, kSmallSize, color(kDim));
  sheet.text(fixedText(seconds, 0) + " s", kAxisRight - 0.03, y, kSmallSize, color(kDim));
}

/// A world's curves in the axes, and their last values above, at a `place` that counts from the right.
void drawCurves(Sheet& sheet, Mode mode, const std::vector<Divergence>& steps, int time_scale, std::size_t place) {
  for (const Strip& strip : kStrips) {
    sheet.line(Marker::LINE_STRIP, colorOf(mode), kCurveWidth, peaksOf(curveOf(steps, strip, time_scale)));
    sheet.text(fixedText(steps.back().*strip.component, 3), kValueX - kValuePitch * static_cast<double>(place),
               strip.bottom + kAxisHeight + kTitleAbove, kSmallSize, colorOf(mode));
  }
}

/// Through both strips, where a world leaves the bound; nothing if it stays within.
void drawMark(Sheet& sheet, Mode mode, const std::optional<Parting>& parting, int time_scale) {
  Points mark;
  if (parting) {
    for (const Strip& strip : kStrips) {
      const double x = xAt(parting->step, time_scale);
      mark.push_back(point(x, strip.bottom, kAxisZ));
      mark.push_back(point(x, strip.bottom + kAxisHeight, kAxisZ));
    }
  }
  sheet.line(Marker::LINE_LIST, colorOf(mode), kMarkWidth, std::move(mark));
}

}  // namespace

void drawAxes(Sheet& sheet) {
  for (const Strip& strip : kStrips) {
    drawAxes(sheet, strip);
  }
}

void drawCurves(Sheet& sheet, const Episode& episode, const std::vector<Mode>& modes, const Bound& bound) {
  const pusht::Trace& reference = episode.rollout(kReferenceClosed).trace();
  const int time_scale = timeScale(episode.steps());
  std::size_t place = 0;
  for (const Mode mode : modes) {
    const pusht::Trace& trace = episode.rollout(mode).trace();
    drawCurves(sheet, mode, divergenceBySteps(reference, trace), time_scale, place++);
    drawMark(sheet, mode, partingOf(reference, trace, bound), time_scale);
  }
  drawTimeLabels(sheet, time_scale);
}

}  // namespace sim2sim
