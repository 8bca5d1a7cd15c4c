// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/live/picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/ros/transforms.hpp"
#include "pusht_task/ros/world_markers.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_eval/protocol/divergence.hpp"
#include "sim2sim_eval/results/text.hpp"

namespace sim2sim {

using pusht::color;
using pusht::fixedText;
using pusht::frameLockedMarker;
using std_msgs::ColorRGBA;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

namespace {

using Points = std::vector<geometry_msgs::Point>;

constexpr Mode kMiddle = kEngineClosed;
constexpr double kTableSpacing = 0.96;  // [m] between the centres of neighbouring tables

// Three colours that stay far apart in all common colour-vision deficiencies, on a dark background.
constexpr std::array<std::uint32_t, kModeCount> kWorldColors = {0x5AAAFF, 0xF0DC46, 0xEE6677};
constexpr std::uint32_t kBright = 0xF4F4F2;
constexpr std::uint32_t kDim = 0xA7B0C0;
constexpr std::uint32_t kAxis = 0x7A8496;
constexpr std::uint32_t kGrid = 0x3A4150;
constexpr std::uint32_t kPaper = 0x1F242E;
constexpr std::uint32_t kCard = 0x14171D;  // as the background of rviz

// The layout in the frame of a table, whose walls end at +-0.43; all in metres.
constexpr double kHeadlineY = 0.70;
constexpr double kTitleY = 0.615;
constexpr double kResultY = 0.545;
constexpr double kCertaintyY = 0.485;
constexpr double kStatusY = -0.475;
constexpr double kEndY = -0.995;
constexpr std::array<std::pair<double, double>, 2> kCards = {{{-1.03, -0.445}, {0.445, 0.75}}};  // from y to y
constexpr double kAxisLeft = -0.34;
constexpr double kAxisRight = 0.43;
constexpr double kAxisHeight = 0.13;
constexpr double kTickLabelX = kAxisLeft - 0.04;
constexpr double kTickLabelBelow = 0.028;
constexpr double kStripTitleX = -0.15;
constexpr double kStripTitleAbove = 0.03;
constexpr double kValueX = 0.385;  // of the rightmost curve's value; those of others are left of it
constexpr double kValuePitch = 0.135;

constexpr double kHeadlineSize = 0.05;
constexpr double kTitleSize = 0.058;
constexpr double kResultSize = 0.046;
constexpr double kSmallSize = 0.034;

constexpr double kThinLine = 0.002;
constexpr double kCurveWidth = 0.006;
constexpr double kTrailWidth = 0.006;
constexpr double kOutlineWidth = 0.005;
constexpr double kEdgeWidth = 0.012;

// What covers what: heights above the table, far enough apart for rviz to tell (see world_markers.cpp).
constexpr double kLayer = 0.015;
constexpr double kTrailZ = 0.0;
constexpr double kGhostZ = 2.0 * pusht::kTeeFrameHeight + kLayer;
constexpr double kEdgeZ = pusht::kWallHeight + kLayer;
constexpr double kCardZ = 2.0 * pusht::kPusherFrameHeight + kLayer;  // an engine's pusher may leave the table: below it
constexpr double kPaperZ = kCardZ + kLayer;
constexpr double kGridZ = kPaperZ + kLayer;
constexpr double kAxisZ = kGridZ + kLayer;
constexpr double kCurveZ = kAxisZ + kLayer;
constexpr double kTextZ = kCurveZ + kLayer;
constexpr float kGhostOpacity = 0.35F;

constexpr std::size_t kMaxLinePoints = 75;  // of a trail or curve, about: bounds the size of an update
constexpr double kTrailSpacing = 0.002;     // [m] up to which a tee rests
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

ColorRGBA colorOf(Mode mode, float opacity = 1.0F) { return color(kWorldColors[mode], opacity); }

geometry_msgs::Point point(double x, double y, double z) {
  geometry_msgs::Point point;
  point.x = x;
  point.y = y;
  point.z = z;
  return point;
}

double heightIn(const Strip& strip, double value) {
  return strip.bottom + kAxisHeight * std::min(value / strip.full_scale, 1.0);
}

/// The points that a long line is drawn with: evenly spaced, and the last.
Points thinned(const Points& points) {
  Points kept;
  const std::size_t stride = points.size() / kMaxLinePoints + 1;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    kept.push_back(points[i]);
  }
  if (!points.empty() && (points.size() - 1) % stride != 0) {
    kept.push_back(points.back());
  }
  return kept;
}

/// The points that a long curve is drawn with: its ends, and the highest of each stretch, so that no peak is lost.
Points peaksOf(const Points& curve) {
  if (curve.size() <= kMaxLinePoints) {
    return curve;
  }
  Points kept = {curve.front()};
  const auto stride = static_cast<std::ptrdiff_t>(curve.size() / kMaxLinePoints + 1);
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

/// The way of a tee; where it rests there is one point.
Points trailOf(const pusht::Trace& trace) {
  Points trail;
  const pusht::WorldState* last = nullptr;
  for (const pusht::WorldState& state : trace.states) {
    if (last == nullptr || (state.tee_position - last->tee_position).norm() > kTrailSpacing) {
      last = &state;
      trail.push_back(point(state.tee_position.x(), state.tee_position.y(), kTrailZ));
    }
  }
  return trail;
}

Points curveOf(const std::vector<Divergence>& steps, const Strip& strip, int time_scale) {
  Points curve;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const double x = kAxisLeft + (kAxisRight - kAxisLeft) * static_cast<double>(k) / time_scale;
    curve.push_back(point(x, heightIn(strip, steps[k].*strip.component), kCurveZ));
  }
  return curve;
}

/// Along the tops of the walls, as a LINE_LIST: a LINE_STRIP gets thin at corners.
Points wallEdges() {
  constexpr double kEdge = pusht::kWallInnerFace + kEdgeWidth;
  constexpr double kEnd = kEdge + 0.5 * kEdgeWidth;
  return {point(-kEnd, kEdge, kEdgeZ),  point(kEnd, kEdge, kEdgeZ),  point(-kEnd, -kEdge, kEdgeZ),
          point(kEnd, -kEdge, kEdgeZ),  point(kEdge, -kEnd, kEdgeZ), point(kEdge, kEnd, kEdgeZ),
          point(-kEdge, -kEnd, kEdgeZ), point(-kEdge, kEnd, kEdgeZ)};
}

/// Whose divergence is drawn below a table, from the right: its own, and below the reference both others'.
std::vector<Mode> curvesBelow(Mode mode) {
  return mode == kReferenceClosed ? std::vector<Mode>{kEngineReplay, kEngineClosed} : std::vector<Mode>{mode};
}

/// Everything that is drawn in the frame of one table, in a namespace of its own.
class Sheet {
 public:
  explicit Sheet(const std::string& prefix) : prefix_(prefix), frame_(prefix + "/table") {}

  Marker& add(int type, const ColorRGBA& color) {
    return markers_.emplace_back(frameLockedMarker(frame_, type, color));
  }

  void line(int type, const ColorRGBA& color, double width, Points points) {
    Marker& line = add(type, color);
    line.scale.x = width;
    line.action = points.size() < 2 ? Marker::DELETE : Marker::ADD;
    line.points = std::move(points);
  }

  void text(const std::string& text, double x, double y, double size, const ColorRGBA& color) {
    Marker& marker = add(Marker::TEXT_VIEW_FACING, color);
    marker.pose.position = point(x, y, kTextZ);
    marker.scale.z = size;
    marker.action = text.empty() ? Marker::DELETE : Marker::ADD;
    marker.text = text;
  }

  void appendTo(MarkerArray& array, const std::string& layer) {
    pusht::enumerate(prefix_ + "/" + layer, markers_);
    array.markers.insert(array.markers.end(), markers_.begin(), markers_.end());
  }

 private:
  std::string prefix_;
  std::string frame_;
  std::vector<Marker> markers_;
};

/// What texts and axes above and below a table are written on.
void drawCards(Sheet& sheet) {
  for (const auto& [bottom, top] : kCards) {
    Marker& card = sheet.add(Marker::CUBE, color(kCard));
    card.pose.position = point(0.0, 0.5 * (bottom + top), kCardZ);
    card.scale.x = kTableSpacing;
    card.scale.y = top - bottom;
    card.scale.z = 0.001;
  }
}

void drawAxes(Sheet& sheet, const Strip& strip) {
  constexpr double kCenter = 0.5 * (kAxisLeft + kAxisRight);
  const double top = strip.bottom + kAxisHeight;
  Marker& paper = sheet.add(Marker::CUBE, color(kPaper));
  paper.pose.position = point(kCenter, 0.5 * (strip.bottom + top), kPaperZ);
  paper.scale.x = kAxisRight - kAxisLeft;
  paper.scale.y = kAxisHeight;
  paper.scale.z = 0.001;

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
  sheet.text(strip.title, kStripTitleX, top + kStripTitleAbove, kSmallSize, color(kDim));
}

void drawTimeLabels(Sheet& sheet, int time_scale) {
  const double y = kStrips.back().bottom - kTickLabelBelow;
  const double seconds = time_scale * pusht::kControlStep;
  sheet.text("0", kAxisLeft, y, kSmallSize, color(kDim));
  sheet.text(fixedText(0.5 * seconds, 0), 0.5 * (kAxisLeft + kAxisRight), y, kSmallSize, color(kDim));
  sheet.text(fixedText(seconds, 0) + " s", kAxisRight - 0.03, y, kSmallSize, color(kDim));
}

/// The tee of another world, over this one's.
void drawGhost(Sheet& sheet, Mode mode, const pusht::WorldState& state) {
  geometry_msgs::Pose pose;
  pose.position = point(state.tee_position.x(), state.tee_position.y(), kGhostZ);
  pose.orientation.z = std::sin(0.5 * state.tee_yaw);
  pose.orientation.w = std::cos(0.5 * state.tee_yaw);

  Marker& surface = sheet.add(Marker::TRIANGLE_LIST, colorOf(mode, kGhostOpacity));
  surface.pose = pose;
  surface.scale.x = surface.scale.y = surface.scale.z = 1.0;
  surface.points = pusht::teeSurface();
  Marker& outline = sheet.add(Marker::LINE_STRIP, colorOf(mode));
  outline.pose = pose;
  outline.scale.x = kOutlineWidth;
  outline.points = pusht::teeOutline();
}

/// A figure of the finished episodes in large, and how sure it is in small.
struct Result {
  std::string figure;
  std::string certainty;
};

Result successResult(const SuccessRate& rate, int episodes) {
  return {
      "success " + std::to_string(rate.successes) + "/" + std::to_string(episodes) + " = " + fixedText(rate.rate, 2),
      "95% interval " + bracketed(rate.interval, 2)};
}

Result divergenceResult(const Summary& summary) {
  const Estimate& position = summary.mean(kEngineReplay, "mean_position_divergence");
  const Estimate& angle = summary.mean(kEngineReplay, "mean_angle_divergence");
  Result result{"divergence " + fixedText(position.value, 3) + " m" + doubtMark(summary, "mean_position_divergence") +
                    ", " + fixedText(angle.value, 2) + " rad" + doubtMark(summary, "mean_angle_divergence"),
                ""};
  if (position.interval && angle.interval) {
    result.certainty =
        "95% intervals " + bracketed(*position.interval, 3) + " m, " + bracketed(*angle.interval, 2) + " rad";
  }
  return result;
}

Result resultOf(Mode mode, const Summary& summary) {
  switch (mode) {
    case kReferenceClosed:
      return successResult(summary.reference, summary.episodes);
    case kEngineClosed:
      return successResult(summary.engine, summary.episodes);
    default:
      return divergenceResult(summary);
  }
}

/// What the finished episodes say, above the table.
void drawResult(Sheet& sheet, const Result& result) {
  sheet.text(result.figure, 0.0, kResultY, kResultSize, color(kBright));
  sheet.text(result.certainty, 0.0, kCertaintyY, kSmallSize, color(kDim));
}

/// How far the tee has come, and whether that is enough, below the table and around it.
void drawStatus(Sheet& sheet, Mode mode, const pusht::Rollout& rollout) {
  const pusht::PoseError error = rollout.error();
  const std::string off_target = fixedText(error.position, 3) + " m, " + fixedText(error.angle, 2) + " rad off target";
  if (rollout.success()) {
    sheet.text("success: " + off_target, 0.0, kStatusY, kSmallSize, colorOf(mode));
    sheet.line(Marker::LINE_LIST, colorOf(mode), kEdgeWidth, wallEdges());
  } else {
    sheet.text(off_target, 0.0, kStatusY, kSmallSize, color(kDim));
    sheet.line(Marker::LINE_LIST, colorOf(mode), kEdgeWidth, {});
  }
}

/// A world's curves in the axes, and their last values above, at a `place` that counts from the right.
void drawCurves(Sheet& sheet, Mode mode, const std::vector<Divergence>& steps, int time_scale, std::size_t place) {
  for (const Strip& strip : kStrips) {
    sheet.line(Marker::LINE_STRIP, colorOf(mode), kCurveWidth, peaksOf(curveOf(steps, strip, time_scale)));
    sheet.text(fixedText(steps.back().*strip.component, 3), kValueX - kValuePitch * static_cast<double>(place),
               strip.bottom + kAxisHeight + kStripTitleAbove, kSmallSize, colorOf(mode));
  }
}

std::string secondsText(int steps) { return fixedText(steps * pusht::kControlStep, 1) + " s"; }

/// Why curves below a table end while the episode goes on; empty while all go on.
std::string endOfCurves(const Episode& episode, Mode mode) {
  std::vector<Mode> ends = {kReferenceClosed};
  for (const Mode other : curvesBelow(mode)) {
    ends.push_back(other);
  }
  for (const Mode end : ends) {
    const int steps = episode.rollout(end).steps();
    if (steps < episode.steps()) {
      return "from " + secondsText(steps) + ": " + (end == kReferenceClosed ? "the reference" : "the engine") +
             " has succeeded";
    }
  }
  return "";
}

std::string headline(const RunConfiguration& run, const Episode& episode, const std::optional<Summary>& summary) {
  if (summary && summary->episodes == run.protocol.episodes) {
    return "policy " + run.policy + ": finished, " + std::to_string(summary->episodes) + " episodes";
  }
  return "policy " + run.policy + ", episode " + std::to_string(episode.index()) + ", " + secondsText(episode.steps());
}

/// The full width of the time axes [control steps].
int timeScale(int steps) {
  return *std::find_if(kTimeScales.begin(), kTimeScales.end() - 1, [steps](int scale) { return steps <= scale; });
}

}  // namespace

Picture::Picture(std::array<World, kModeCount> worlds) : worlds_(std::move(worlds)) {}

std::vector<geometry_msgs::TransformStamped> Picture::frames() const {
  std::vector<geometry_msgs::TransformStamped> frames;
  for (const Mode mode : kModes) {
    const std::string& prefix = worlds_[mode].frame_prefix;
    geometry_msgs::TransformStamped table;
    table.header.frame_id = "world";
    table.child_frame_id = prefix + "/table";
    table.transform.translation.x = kTableSpacing * (static_cast<double>(mode) - static_cast<double>(kMiddle));
    table.transform.rotation.w = 1.0;
    frames.push_back(table);
    frames.push_back(pusht::targetFrame(prefix));
  }
  return frames;
}

MarkerArray Picture::scene() const {
  MarkerArray scene;
  for (const Mode mode : kModes) {
    const World& world = worlds_[mode];
    pusht::WorldColors colors;
    colors.tee = colorOf(mode);
    const MarkerArray geometry = pusht::worldMarkers(world.frame_prefix, colors);
    scene.markers.insert(scene.markers.end(), geometry.markers.begin(), geometry.markers.end());

    Sheet sheet(world.frame_prefix);
    sheet.text(world.title, 0.0, kTitleY, kTitleSize, colorOf(mode));
    drawCards(sheet);
    for (const Strip& strip : kStrips) {
      drawAxes(sheet, strip);
    }
    sheet.appendTo(scene, "axes");
  }
  return scene;
}

MarkerArray Picture::update(const RunConfiguration& run, const Episode& episode,
                            const std::optional<Summary>& summary) const {
  const pusht::Trace& reference = episode.rollout(kReferenceClosed).trace();
  const int time_scale = timeScale(episode.steps());

  MarkerArray update;
  for (const Mode mode : kModes) {
    const pusht::Rollout& rollout = episode.rollout(mode);
    Sheet sheet(worlds_[mode].frame_prefix);
    sheet.line(Marker::LINE_STRIP, colorOf(mode), kTrailWidth, thinned(trailOf(rollout.trace())));
    if (mode == kEngineReplay) {
      drawGhost(sheet, kReferenceClosed, reference.states.back());
    }
    drawResult(sheet, summary ? resultOf(mode, *summary) : Result{});
    drawStatus(sheet, mode, rollout);
    std::size_t place = 0;
    for (const Mode other : curvesBelow(mode)) {
      drawCurves(sheet, other, divergenceBySteps(reference, episode.rollout(other).trace()), time_scale, place++);
    }
    drawTimeLabels(sheet, time_scale);
    sheet.text(endOfCurves(episode, mode), 0.0, kEndY, kSmallSize, color(kDim));
    if (mode == kMiddle) {
      sheet.text(headline(run, episode, summary), 0.0, kHeadlineY, kHeadlineSize, color(kBright));
    }
    sheet.appendTo(update, "episode");
  }
  return update;
}

}  // namespace sim2sim
