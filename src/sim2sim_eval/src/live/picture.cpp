// SPDX-License-Identifier: BSD-3-Clause
#include "live/picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "live/canvas.hpp"
#include "live/captions.hpp"
#include "live/legend.hpp"
#include "live/table_view.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/loop.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_serving/transforms.hpp"
#include "sim2sim_serving/world_markers.hpp"

namespace sim2sim {

using Eigen::Vector2d;
using pusht::color;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

namespace {

constexpr Mode kMiddle = kEngineClosed;
constexpr double kSpacing = 0.96;  // [m] between the middles of neighboring views

// Layout in the frame of the middle view, in meters. rviz_window knows the size of the whole.
constexpr double kWholeWidth = 2.86;
constexpr double kQuestionY = 0.955;
constexpr double kAnswerY = 0.877;
constexpr double kSubheadSize = 0.052;
constexpr double kHeadlineSize = 0.066;
constexpr std::size_t kHeadlineLength = 145;  // bytes; a long answer has smaller letters
constexpr double kStateY = 0.790;
constexpr double kTitleY = 0.700;
constexpr double kSubtitleY = 0.636;
constexpr double kResultY = 0.574;
constexpr double kCertaintyY = 0.519;
constexpr double kStatusY = -0.607;
constexpr double kFirstDivergenceY = -0.665;
constexpr double kParametersY = -0.727;
constexpr double kParametersPitch = 0.052;
constexpr std::size_t kParametersLines = 2;
constexpr std::size_t kLineLength = 48;  // bytes of small text in the width of a view
constexpr double kLegendY = -0.870;
const Pane kPane = {{0.0, -0.036}, {0.92, 1.04}};

// Overlay: one large view, and a card beside it.
constexpr const char* kOverlay = "overlay";
constexpr double kOverlayY = -2.6;
const Pane kOverlayPane = {{-0.47, -0.12}, {1.90, 1.72}};
constexpr double kCardX = 0.96;
constexpr double kCardTop = 0.66;
constexpr double kCardBlock = 0.29;
constexpr double kCardPitch = 0.058;
constexpr double kCardLegendY = -0.45;

constexpr double kTableEdge = 0.012;
constexpr double kArrowTime = 0.25;               // [s] an arrow ends where the pusher would be then
constexpr double kFirstDivergenceRadius = 0.018;  // [m] of the ring around a tee that leaves the bound
constexpr double kAxisBegin = 0.05;               // [m] from the target, of the lines that show its tolerance
constexpr double kAxisBeyond = 0.02;              // [m] from the end of the stem to theirs
constexpr double kTeeMark = 0.045;                // [m] of the mark of a tee that is beyond the edge of a view
constexpr double kPusherMark = 0.022;

constexpr std::size_t kMaxTrailPoints = 75;  // about: bounds the size of an update
constexpr double kTrailSpacing = 0.002;      // [m] up to which a tee rests

std::string viewFrame(const std::string& prefix) { return prefix + "/window"; }

/// Path of a tee; `shares` is the share of its length before each point, in [0, 1].
struct Way {
  std::vector<Vector2d> points;
  std::vector<double> shares;
};

/// Path of a tee, with evenly spaced points and the last; where the tee rests there is one point.
Way wayOf(const pusht::Trace& trace) {
  std::vector<Vector2d> all;
  for (const pusht::WorldState& state : trace.states) {
    if (all.empty() || (state.tee_position - all.back()).norm() > kTrailSpacing) {
      all.push_back(state.tee_position);
    }
  }
  Way way;
  const auto add = [&](std::size_t i) {
    way.points.push_back(all[i]);
    way.shares.push_back(static_cast<double>(i) / static_cast<double>(std::max<std::size_t>(1, all.size() - 1)));
  };
  const std::size_t stride = all.size() / kMaxTrailPoints + 1;
  for (std::size_t i = 0; i < all.size(); i += stride) {
    add(i);
  }
  if ((all.size() - 1) % stride != 0) {
    add(all.size() - 1);
  }
  return way;
}

/// [m] From the tee's origin to the end of its stem.
double stemEndOf(const pusht::Physics& physics) { return physics.stem_offset + physics.stem_half_length; }

/// Target and its tolerance: the tee's origin must lie in the ring, its stem between the two lines. A task that is
/// judged by coverage has none.
void drawTarget(Canvas& canvas, const TableView& view, const pusht::Task& task, const std_msgs::ColorRGBA& mark) {
  const auto& [position, yaw] = task.target;
  const pusht::SuccessRule& rule = task.success;
  const bool has_tolerance = !rule.coverage;
  const auto shown = [&](const std::vector<Vector2d>& points) {
    return has_tolerance ? points : std::vector<Vector2d>();
  };
  view.tee(canvas, color(kBright, kTargetOpacity), color(kBright), pusht::stateAtTarget(task), kTargetZ);
  view.line(canvas, mark, kMarkWidth, shown(circleOf(position, rule.position_tolerance)), kMarkZ);
  for (const double side : {-1.0, 1.0}) {
    const double angle = yaw + side * rule.angle_tolerance;
    const Vector2d along(std::sin(angle), -std::cos(angle));
    const double end = stemEndOf(task.physics) + kAxisBeyond;
    view.line(canvas, mark, kMarkWidth, shown({position + kAxisBegin * along, position + end * along}), kMarkZ);
  }
}

/// The tee's origin and stem, to be seen against the tolerance.
void drawAxis(Canvas& canvas, const TableView& view, const pusht::WorldState& state, const pusht::Task& task,
              const std_msgs::ColorRGBA& color) {
  const Vector2d stem(std::sin(state.tee_yaw), -std::cos(state.tee_yaw));
  view.line(canvas, color, kMarkWidth, {state.tee_position, state.tee_position + stemEndOf(task.physics) * stem},
            kMarkZ);
}

/// Whether a world moves on. A replay has always made the reference's steps, and moves as long as the reference does.
bool moves(Mode mode, const Episode& episode) {
  return episode.goesOn(mode == kEngineReplay ? kReferenceClosed : mode);
}

/// The pusher; what it was told in the last control step, in white, and how fast it is, unless the world rests. An
/// arrow of a velocity ends where the pusher would be after kArrowTime, that of a position there.
void drawPusher(Canvas& canvas, const TableView& view, Mode mode, const Episode& episode,
                const std_msgs::ColorRGBA& body) {
  const pusht::Task& task = episode.rollout(mode).task();
  const pusht::Trace& trace = episode.rollout(mode).trace();
  const pusht::WorldState& state = trace.states.back();
  Vector2d commanded = Vector2d::Zero();
  Vector2d actual = Vector2d::Zero();
  if (moves(mode, episode) && trace.steps() > 0) {
    const Vector2d command = pusht::commandOf(trace.actions.back(), task);
    const bool is_position = task.physics.drive == pusht::Drive::kPosition;
    commanded = is_position ? Vector2d(command - state.pusher_position) : Vector2d(kArrowTime * command);
    actual = kArrowTime * state.pusher_velocity;
  }
  view.area(canvas, body, circleOf(state.pusher_position, task.physics.pusher_radius), kPusherZ);
  view.arrow(canvas, color(kBright), kCommandWidth, state.pusher_position, commanded, kArrowZ);
  view.arrow(canvas, colorOf(mode), kVelocityWidth, state.pusher_position, actual, kArrowZ + 0.5 * kLayer);
  view.edgeMark(canvas, body, kPusherMark, state.pusher_position);
}

/// The way of the tee, where it left the bound around the reference, and where it is if that is out of sight.
void drawWay(Canvas& canvas, const TableView& view, Mode mode, const pusht::Trace& trace,
             const std::optional<FirstDivergence>& first_divergence) {
  const Way way = wayOf(trace);
  view.way(canvas, colorOf(mode), kTrailWidth, way.points, way.shares, kTrailZ);
  std::vector<Vector2d> ring;
  if (first_divergence) {
    ring =
        circleOf(trace.states[static_cast<std::size_t>(first_divergence->step)].tee_position, kFirstDivergenceRadius);
  }
  view.line(canvas, colorOf(mode), kMarkWidth, ring, kMarkZ);
  view.edgeMark(canvas, colorOf(mode), kTeeMark, trace.states.back().tee_position);
}

/// Edge of a view.
void drawEdge(Canvas& canvas, const Pane& pane, const std_msgs::ColorRGBA& color, double width) {
  const Vector2d half = 0.5 * pane.size;
  Points points;
  for (const auto& [x, y] : {std::pair(-1.0, -1.0), std::pair(1.0, -1.0), std::pair(1.0, 1.0), std::pair(-1.0, 1.0),
                             std::pair(-1.0, -1.0)}) {
    points.push_back(point(pane.center.x() + x * half.x(), pane.center.y() + y * half.y(), kEdgeZ));
  }
  canvas.line(Marker::LINE_STRIP, color, width, std::move(points));
}

/// The question above, the answer below it; without a question the answer alone.
void drawHeadline(Canvas& canvas, const std::string& headline) {
  const std::size_t question = headline.find("? ");
  const std::size_t answer = question == std::string::npos ? 0 : question + 2;
  canvas.text(headline.substr(0, answer), 0.0, kQuestionY, kSubheadSize, color(kDim));
  const std::string text = pusht::fitted(headline.substr(answer), kHeadlineLength);
  const double size = kWholeWidth / (kCharacterWidth * static_cast<double>(std::max<std::size_t>(1, text.size())));
  canvas.text(text, 0.0, kAnswerY, std::min(kHeadlineSize, size), color(kBright));
}

const pusht::WorldState& stateOf(const Episode& episode, Mode mode) {
  return episode.rollout(mode).trace().states.back();
}

/// The color of the marks at the target: that of the world once its tee is near enough.
std_msgs::ColorRGBA markColor(Mode mode, const Episode& episode) {
  const pusht::Rollout& rollout = episode.rollout(mode);
  return rollout.solved() || rollout.success() ? colorOf(mode) : color(kDim);
}

geometry_msgs::TransformStamped standing(const std::string& child, double x, double y) {
  geometry_msgs::TransformStamped frame;
  frame.header.frame_id = "world";
  frame.child_frame_id = child;
  frame.transform.translation.x = x;
  frame.transform.translation.y = y;
  frame.transform.rotation.w = 1.0;
  return frame;
}

std::uint32_t bandColor(RunState state) {
  switch (state) {
    case RunState::kWaits:
      return pusht::palette::kWaits;
    case RunState::kPaused:
      return pusht::palette::kPaused;
    case RunState::kFinished:
      return pusht::palette::kFinished;
    case RunState::kEnded:
      return pusht::palette::kEnded;
    default:
      return kCard;
  }
}

}  // namespace

Picture::Picture(std::array<World, kModeCount> worlds, const pusht::Task& task)
    : worlds_(std::move(worlds)), task_(&task) {}

Picture Picture::of(const RunConfiguration& run, const std::array<std::string, kModeCount>& frame_prefixes) {
  std::array<World, kModeCount> worlds;
  for (const Mode mode : kModes) {
    SimulatorRecord simulator = mode == kReferenceClosed ? run.reference : run.engine;
    if (mode == kEngineReplay) {  // its actions have passed the reference's loop
      const auto is_of_loop = [](const std::string& name) { return !pusht::loopParameterOf(name).empty(); };
      simulator.changed.erase(std::remove_if(simulator.changed.begin(), simulator.changed.end(), is_of_loop),
                              simulator.changed.end());
    }
    worlds[mode] = {frame_prefixes[mode], pusht::fitted(titleOf(mode, run), kLineLength),
                    pusht::fitted(subtitleOf(mode, run), kLineLength),
                    changedParameters(simulator, kParametersLines, kLineLength)};
  }
  return Picture(std::move(worlds), run.protocol.runTask());
}

std::vector<geometry_msgs::TransformStamped> Picture::frames() const {
  std::vector<geometry_msgs::TransformStamped> frames;
  for (const Mode mode : kModes) {
    const std::string& prefix = worlds_[mode].frame_prefix;
    const double x = kSpacing * (static_cast<double>(mode) - static_cast<double>(kMiddle));
    frames.push_back(standing(prefix + "/table", x, 0.0));
    frames.push_back(pusht::targetFrame(prefix, task_->target));
    frames.push_back(standing(viewFrame(prefix), x, 0.0));
  }
  frames.push_back(standing(viewFrame(kOverlay), 0.0, kOverlayY));
  return frames;
}

MarkerArray Picture::scene() const {
  MarkerArray scene;
  for (const Mode mode : kModes) {
    const World& world = worlds_[mode];
    Canvas canvas(viewFrame(world.frame_prefix));
    canvas.text(world.title, 0.0, kTitleY, kTitleSize, colorOf(mode));
    canvas.text(world.subtitle, 0.0, kSubtitleY, kResultSize, color(kBright));
    for (std::size_t line = 0; line < kParametersLines; ++line) {
      canvas.text(line < world.parameters.size() ? world.parameters[line] : "", 0.0,
                  kParametersY - kParametersPitch * static_cast<double>(line), kSmallSize, color(kDim));
    }
    if (mode == kMiddle) {
      drawLegend(canvas, {-0.5 * kWholeWidth, kLegendY}, 3);
    }
    canvas.appendTo(scene, world.frame_prefix + "/captions");
  }
  Canvas card(viewFrame(kOverlay));
  drawLegend(card, {kCardX - 0.41, kCardLegendY}, 1);
  card.appendTo(scene, std::string(kOverlay) + "/captions");
  return scene;
}

MarkerArray Picture::update(const RunConfiguration& run, const Episode& episode, const std::optional<Summary>& summary,
                            const std::string& headline) const {
  const pusht::Trace& reference = episode.rollout(kReferenceClosed).trace();
  const TableView view(kPane, regionOf(episode, kPane), *task_);
  const pusht::WorldColors colors;
  MarkerArray update;
  for (const Mode mode : kModes) {
    const pusht::Rollout& rollout = episode.rollout(mode);
    const std::optional<FirstDivergence> first_divergence =
        firstDivergenceOf(reference, rollout.trace(), run.protocol.bound(), rollout.task());
    Canvas canvas(viewFrame(worlds_[mode].frame_prefix));
    view.table(canvas, colors.table, colors.walls);
    drawTarget(canvas, view, *task_, markColor(mode, episode));
    drawWay(canvas, view, mode, rollout.trace(), first_divergence);
    view.tee(canvas, colorOf(mode), colorOf(mode), stateOf(episode, mode), kTeeZ);
    if (mode == kEngineReplay) {
      view.tee(canvas, colorOf(kReferenceClosed, kGhostOpacity), colorOf(kReferenceClosed), reference.states.back(),
               kGhostZ);
    }
    drawAxis(canvas, view, stateOf(episode, mode), *task_, color(kBright));
    drawPusher(canvas, view, mode, episode, color(kBright));
    drawEdge(canvas, kPane, rollout.success() ? colorOf(mode) : colors.walls,
             rollout.success() ? kTableEdge : 0.5 * kTableEdge);
    const Result result = summary ? resultOf(mode, *summary) : Result{};
    canvas.text(result.figure, 0.0, kResultY, kResultSize, color(kBright));
    canvas.text(result.certainty, 0.0, kCertaintyY, kSmallSize, color(kDim));
    canvas.text(statusOf(mode, episode), 0.0, kStatusY, kSmallSize, rollout.success() ? colorOf(mode) : color(kDim));
    canvas.text(firstDivergenceText(first_divergence), 0.0, kFirstDivergenceY, kSmallSize, colorOf(mode));
    if (mode == kMiddle) {
      drawHeadline(canvas, headline);
    }
    canvas.appendTo(update, worlds_[mode].frame_prefix + "/episode");
  }
  return update;
}

MarkerArray Picture::overlay(const RunConfiguration& run, const Episode& episode, const std::string& headline) const {
  const pusht::Trace& reference = episode.rollout(kReferenceClosed).trace();
  const TableView view(kOverlayPane, regionOf(episode, kOverlayPane), *task_);
  const pusht::WorldColors colors;
  Canvas canvas(viewFrame(kOverlay));
  view.table(canvas, colors.table, colors.walls);
  drawTarget(canvas, view, *task_, markColor(kReferenceClosed, episode));
  drawEdge(canvas, kOverlayPane, colors.walls, 0.5 * kTableEdge);
  for (const Mode mode : kModes) {
    const pusht::Trace& trace = episode.rollout(mode).trace();
    const std::optional<FirstDivergence> first_divergence =
        firstDivergenceOf(reference, trace, run.protocol.bound(), *task_);
    const float opacity = mode == kReferenceClosed ? 1.0F : kGhostOpacity;
    drawWay(canvas, view, mode, trace, first_divergence);
    view.tee(canvas, colorOf(mode, opacity), colorOf(mode), trace.states.back(),
             kTeeZ + 0.5 * kLayer * static_cast<double>(mode));
    drawAxis(canvas, view, trace.states.back(), *task_, mode == kReferenceClosed ? color(kBright) : colorOf(mode));
    drawPusher(canvas, view, mode, episode, colorOf(mode, opacity));
    double y = kCardTop - kCardBlock * static_cast<double>(mode);
    for (const std::string& line : {worlds_[mode].title, worlds_[mode].subtitle, statusOf(mode, episode),
                                    firstDivergenceText(first_divergence)}) {
      const bool first = y == kCardTop - kCardBlock * static_cast<double>(mode);
      canvas.text(line, kCardX, y, first ? kResultSize : kSmallSize, first ? colorOf(mode) : color(kDim));
      y -= kCardPitch;
    }
  }
  drawHeadline(canvas, headline);
  MarkerArray overlay;
  canvas.appendTo(overlay, std::string(kOverlay) + "/episode");
  return overlay;
}

MarkerArray stateMarkers(RunState state, const std::string& text) {
  constexpr std::size_t kLength = 120;  // bytes that fit
  constexpr double kHalfHeight = 0.036;
  Canvas canvas("world");
  for (const double middle : {0.0, kOverlayY}) {
    const double y = middle + kStateY;
    canvas.rectangle(color(bandColor(state)), -0.5 * kWholeWidth, y - kHalfHeight, 0.5 * kWholeWidth, y + kHalfHeight,
                     kBandZ);
    canvas.text(pusht::fitted(text, kLength), 0.0, y, kResultSize, color(kBright));
  }
  MarkerArray markers;
  canvas.appendTo(markers, "state");
  return markers;
}

}  // namespace sim2sim
