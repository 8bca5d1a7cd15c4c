// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/live/picture.hpp"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/ros/transforms.hpp"
#include "pusht_task/ros/world_markers.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_eval/live/sheet.hpp"
#include "sim2sim_eval/live/strips.hpp"
#include "sim2sim_eval/results/text.hpp"

namespace sim2sim {

using pusht::color;
using pusht::fixedText;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

namespace {

constexpr Mode kMiddle = kEngineClosed;
constexpr double kTableSpacing = 0.96;  // [m] between the centres of neighbouring tables

// The layout in the frame of a table, whose walls end at +-0.43; all in metres.
constexpr double kHeadlineY = 0.70;
constexpr double kTitleY = 0.615;
constexpr double kResultY = 0.545;
constexpr double kCertaintyY = 0.485;
constexpr double kStatusY = -0.461;
constexpr double kPartingY = -0.506;
constexpr double kEndY = -0.996;
constexpr double kSettingsY = -1.041;
constexpr std::array<std::pair<double, double>, 2> kCards = {{{-1.07, -0.44}, {0.445, 0.75}}};  // from y to y
constexpr std::size_t kLineLength = 52;  // letters of small text that fit beside each other on a card

// The overlay: all worlds on one table, in front of the others, and a card beside it. Its strips, as those below a
// table, are at the middle of the card.
constexpr const char* kOverlay = "overlay";
const std::string kOverlayTable = "overlay/table";
const std::string kOverlayCard = "overlay/card";
constexpr double kOverlayX = -0.48;
constexpr double kOverlayY = -2.4;
constexpr double kCardX = 0.93;
constexpr double kCardY = 0.72;
constexpr double kCardTop = -0.25;
constexpr double kCardBottom = -1.19;
constexpr double kOverlayHeadlineY = -0.30;
constexpr double kLegendY = -0.37;
constexpr double kLegendPitch = 0.055;
constexpr double kOverlayPartingY = -1.05;
constexpr double kLinePitch = 0.05;

constexpr double kTrailWidth = 0.006;
constexpr double kEdgeWidth = 0.012;
constexpr double kArrowWidth = 0.010;
constexpr float kGhostOpacity = 0.35F;

constexpr double kArrowTime = 0.25;       // [s] an arrow ends where the pusher would be then
constexpr double kPartingRadius = 0.022;  // [m] of the ring around a tee that leaves the bound
constexpr double kAxisBegin = 0.05;       // [m] from the target, of the lines that show its tolerance
constexpr double kAxisEnd = pusht::kStemOffset + pusht::kStemHalfLength + 0.02;

constexpr std::size_t kMaxTrailPoints = 75;  // about: bounds the size of an update
constexpr double kTrailSpacing = 0.002;      // [m] up to which a tee rests

/// The points that a long line is drawn with: evenly spaced, and the last.
template <class Point>
std::vector<Point> thinned(const std::vector<Point>& points) {
  std::vector<Point> kept;
  const std::size_t stride = points.size() / kMaxTrailPoints + 1;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    kept.push_back(points[i]);
  }
  if (!points.empty() && (points.size() - 1) % stride != 0) {
    kept.push_back(points.back());
  }
  return kept;
}

/// The way of a tee, and when it was where; where it rests there is one point.
std::vector<WayPoint> trailOf(const pusht::Trace& trace) {
  const double last_step = std::max(1.0, static_cast<double>(trace.steps()));
  std::vector<WayPoint> trail;
  const pusht::WorldState* last = nullptr;
  for (std::size_t step = 0; step < trace.states.size(); ++step) {
    const pusht::WorldState& state = trace.states[step];
    if (last == nullptr || (state.tee_position - last->tee_position).norm() > kTrailSpacing) {
      last = &state;
      trail.push_back(
          {point(state.tee_position.x(), state.tee_position.y(), kTrailZ), static_cast<double>(step) / last_step});
    }
  }
  return trail;
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

/// What texts and axes above and below a table are written on.
void drawCards(Sheet& sheet) {
  for (const auto& [bottom, top] : kCards) {
    sheet.rectangle(color(kCard), -0.5 * kTableSpacing, bottom, 0.5 * kTableSpacing, top, kCardZ);
  }
}

/// How near to the target the tee must be: its origin in the ring, its stem between the two lines.
void drawTolerance(Sheet& sheet, const std_msgs::ColorRGBA& color) {
  sheet.line(Marker::LINE_STRIP, color, kMarkWidth, circle(0.0, 0.0, kMarkZ, pusht::kPositionTolerance));
  Points sides;
  for (const double angle : {-pusht::kAngleTolerance, pusht::kAngleTolerance}) {
    for (const double radius : {kAxisBegin, kAxisEnd}) {
      sides.push_back(point(radius * std::sin(angle), -radius * std::cos(angle), kMarkZ));
    }
  }
  sheet.line(Marker::LINE_LIST, color, kMarkWidth, std::move(sides));
}

/// The tee's origin and stem, to be seen against the tolerance.
void drawAxis(Sheet& sheet, const pusht::WorldState& state, const std_msgs::ColorRGBA& color) {
  const Eigen::Vector2d stem(std::sin(state.tee_yaw), -std::cos(state.tee_yaw));
  const Eigen::Vector2d end = state.tee_position + (pusht::kStemOffset + pusht::kStemHalfLength) * stem;
  sheet.line(Marker::LINE_STRIP, color, kMarkWidth,
             {point(state.tee_position.x(), state.tee_position.y(), kMarkZ), point(end.x(), end.y(), kMarkZ)});
}

/// What the pusher was told in the last control step, in white, and how fast it is; none once the world rests.
void drawVelocities(Sheet& sheet, Mode mode, const Episode& episode) {
  const pusht::Trace& trace = episode.rollout(mode).trace();
  const pusht::WorldState& state = trace.states.back();
  Eigen::Vector2d commanded = Eigen::Vector2d::Zero();
  Eigen::Vector2d actual = Eigen::Vector2d::Zero();
  if (episode.goesOn(mode) && trace.steps() > 0) {
    commanded = kArrowTime * Eigen::Vector2d(trace.actions.back()[0], trace.actions.back()[1]);
    actual = kArrowTime * state.pusher_velocity;
  }
  const auto from = [&](double z) { return point(state.pusher_position.x(), state.pusher_position.y(), z); };
  sheet.arrow(color(kBright), 0.7 * kArrowWidth, from(kArrowZ), commanded);
  sheet.arrow(colorOf(mode), kArrowWidth, from(kArrowZ + 0.5 * kLayer), actual);
}

/// The way of the tee, and where it left the bound around the reference.
void drawWay(Sheet& sheet, Mode mode, const pusht::Trace& trace, const std::optional<Parting>& parting) {
  sheet.way(colorOf(mode), kTrailWidth, thinned(trailOf(trace)));
  Points ring;
  if (parting) {
    const Eigen::Vector2d& at = trace.states[static_cast<std::size_t>(parting->step)].tee_position;
    ring = circle(at.x(), at.y(), kMarkZ, kPartingRadius);
  }
  sheet.line(Marker::LINE_STRIP, colorOf(mode), kMarkWidth, std::move(ring));
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
  const bool success = rollout.success();
  sheet.text((success ? "success: " : "") + off_target, 0.0, kStatusY, kSmallSize,
             success ? colorOf(mode) : color(kDim));
  sheet.line(Marker::LINE_LIST, colorOf(mode), kEdgeWidth, success ? wallEdges() : Points());
  drawTolerance(sheet, error.inTolerance() || success ? colorOf(mode) : color(kDim));
  drawAxis(sheet, rollout.trace().states.back(), color(kBright));
}

std::string secondsText(int steps) { return fixedText(steps * pusht::kControlStep, 1) + " s"; }

std::string partingText(const std::optional<Parting>& parting) {
  if (!parting) {
    return "";
  }
  return "parts at " + secondsText(parting->step) + ": " + nameOf(parting->cause).label + ", " +
         nameOf(parting->first) + " first";
}

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

std::string headline(const RunConfiguration& run, const Episode& episode, const std::optional<Summary>& summary,
                     std::optional<int> last) {
  if (summary && last == episode.index() && episode.finished()) {  // a replay may be elsewhere
    return "policy " + run.policy + ": finished, " + std::to_string(summary->episodes) + " episodes";
  }
  return "policy " + run.policy + ", episode " + std::to_string(episode.index()) + ", " + secondsText(episode.steps());
}

/// What a simulator has not by default, as long as it fits.
std::string settingsOf(const SimulatorRecord& simulator) {
  std::string text;
  for (const std::string& name : simulator.changed) {
    const nlohmann::ordered_json& value = simulator.parameters.at(name);
    text += (text.empty() ? "" : ", ") + name + " " + (value.is_string() ? value.get<std::string>() : value.dump());
  }
  return pusht::fitted(text, kLineLength);
}

/// How a world differs from the others, whose simulators may be of its kind.
std::string partOf(Mode mode, const RunConfiguration& run) {
  if (mode == kEngineReplay) {
    return "replay";
  }
  return mode == kReferenceClosed && run.reference.title == run.engine.title ? "reference" : "closed loop";
}

geometry_msgs::TransformStamped standing(const std::string& parent, const std::string& child, double x, double y) {
  geometry_msgs::TransformStamped frame;
  frame.header.frame_id = parent;
  frame.child_frame_id = child;
  frame.transform.translation.x = x;
  frame.transform.translation.y = y;
  frame.transform.rotation.w = 1.0;
  return frame;
}

}  // namespace

Picture::Picture(std::array<World, kModeCount> worlds) : worlds_(std::move(worlds)) {}

Picture Picture::of(const RunConfiguration& run, const std::array<std::string, kModeCount>& frame_prefixes) {
  std::array<World, kModeCount> worlds;
  for (const Mode mode : kModes) {
    const SimulatorRecord& simulator = mode == kReferenceClosed ? run.reference : run.engine;
    worlds[mode] = {frame_prefixes[mode], simulator.title + ", " + partOf(mode, run), settingsOf(simulator)};
  }
  return Picture(std::move(worlds));
}

std::vector<geometry_msgs::TransformStamped> Picture::frames() const {
  std::vector<geometry_msgs::TransformStamped> frames;
  for (const Mode mode : kModes) {
    const std::string& prefix = worlds_[mode].frame_prefix;
    const double place = static_cast<double>(mode) - static_cast<double>(kMiddle);
    frames.push_back(standing("world", prefix + "/table", place * kTableSpacing, 0.0));
    frames.push_back(pusht::targetFrame(prefix));
  }
  frames.push_back(standing("world", kOverlayTable, kOverlayX, kOverlayY));
  frames.push_back(pusht::targetFrame(kOverlay));
  frames.push_back(standing(kOverlayTable, kOverlayCard, kCardX, kCardY));
  return frames;
}

MarkerArray Picture::scene() const {
  MarkerArray scene;
  const auto add = [&](const MarkerArray& more) {
    scene.markers.insert(scene.markers.end(), more.markers.begin(), more.markers.end());
  };
  for (const Mode mode : kModes) {
    const World& world = worlds_[mode];
    pusht::WorldColors colors;
    colors.tee = colorOf(mode);
    add(pusht::worldMarkers(world.frame_prefix, colors));

    Sheet sheet(world.frame_prefix + "/table");
    drawCards(sheet);
    sheet.text(world.title, 0.0, kTitleY, kTitleSize, colorOf(mode));
    sheet.text(world.settings, 0.0, kSettingsY, kSmallSize, color(kDim));
    drawAxes(sheet);
    sheet.appendTo(scene, world.frame_prefix + "/axes");
  }

  add(pusht::tableMarkers(kOverlay));
  Sheet card(kOverlayCard);
  card.rectangle(color(kCard), -0.5 * kTableSpacing, kCardBottom, 0.5 * kTableSpacing, kCardTop, kCardZ);
  drawAxes(card);
  card.appendTo(scene, std::string(kOverlay) + "/axes");
  return scene;
}

MarkerArray Picture::update(const RunConfiguration& run, const Episode& episode, const std::optional<Summary>& summary,
                            std::optional<int> last) const {
  const pusht::Trace& reference = episode.rollout(kReferenceClosed).trace();
  const Bound& bound = run.protocol.bound;
  MarkerArray update;
  for (const Mode mode : kModes) {
    const pusht::Rollout& rollout = episode.rollout(mode);
    const std::optional<Parting> parting = partingOf(reference, rollout.trace(), bound);
    Sheet sheet(worlds_[mode].frame_prefix + "/table");
    drawWay(sheet, mode, rollout.trace(), parting);
    if (mode == kEngineReplay) {
      sheet.tee(colorOf(kReferenceClosed, kGhostOpacity), colorOf(kReferenceClosed), reference.states.back(), kGhostZ);
    }
    drawVelocities(sheet, mode, episode);
    drawResult(sheet, summary ? resultOf(mode, *summary) : Result{});
    drawStatus(sheet, mode, rollout);
    sheet.text(partingText(parting), 0.0, kPartingY, kSmallSize, colorOf(mode));
    drawCurves(sheet, episode, curvesBelow(mode), bound);
    sheet.text(endOfCurves(episode, mode), 0.0, kEndY, kSmallSize, color(kDim));
    if (mode == kMiddle) {
      sheet.text(headline(run, episode, summary, last), 0.0, kHeadlineY, kHeadlineSize, color(kBright));
    }
    sheet.appendTo(update, worlds_[mode].frame_prefix + "/episode");
  }
  return update;
}

MarkerArray Picture::overlay(const RunConfiguration& run, const Episode& episode, const std::optional<Summary>& summary,
                             std::optional<int> last) const {
  const pusht::Trace& reference = episode.rollout(kReferenceClosed).trace();
  const Bound& bound = run.protocol.bound;
  MarkerArray overlay;
  Sheet table(kOverlayTable);
  Sheet card(kOverlayCard);
  const pusht::Rollout& solid = episode.rollout(kReferenceClosed);
  drawTolerance(table, solid.error().inTolerance() || solid.success() ? colorOf(kReferenceClosed) : color(kDim));
  for (const Mode mode : kModes) {
    const pusht::Trace& trace = episode.rollout(mode).trace();
    const pusht::WorldState& state = trace.states.back();
    const std::optional<Parting> parting = partingOf(reference, trace, bound);
    const float opacity = mode == kReferenceClosed ? 1.0F : kGhostOpacity;
    card.text(worlds_[mode].title + (mode == kReferenceClosed ? " (solid)" : "") +
                  (episode.rollout(mode).success() ? ": success" : ""),
              0.0, kLegendY - kLegendPitch * static_cast<double>(mode), kSmallSize, colorOf(mode));
    drawWay(table, mode, trace, parting);
    table.tee(colorOf(mode, opacity), colorOf(mode), state,
              kGhostZ - kLayer + 0.5 * kLayer * static_cast<double>(mode));
    drawAxis(table, state, mode == kReferenceClosed ? color(kBright) : colorOf(mode));
    Marker& pusher = table.add(Marker::CYLINDER, colorOf(mode, opacity));
    pusher.pose.position = point(state.pusher_position.x(), state.pusher_position.y(), pusht::kPusherFrameHeight);
    pusher.scale.x = pusher.scale.y = 2.0 * pusht::kPusherRadius;
    pusher.scale.z = 2.0 * pusht::kPusherFrameHeight;
    drawVelocities(table, mode, episode);
    if (mode != kReferenceClosed) {
      card.text(partingText(parting), 0.0, kOverlayPartingY - kLinePitch * static_cast<double>(mode - kEngineClosed),
                kSmallSize, colorOf(mode));
    }
  }
  card.text(headline(run, episode, summary, last), 0.0, kOverlayHeadlineY, kResultSize, color(kBright));
  drawCurves(card, episode, curvesBelow(kReferenceClosed), bound);
  card.text(endOfCurves(episode, kReferenceClosed), 0.0, kEndY, kSmallSize, color(kDim));
  table.appendTo(overlay, std::string(kOverlay) + "/episode");
  card.appendTo(overlay, std::string(kOverlay) + "/card");
  return overlay;
}

}  // namespace sim2sim
