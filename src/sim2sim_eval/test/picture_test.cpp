// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/live/picture.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ros/serialization.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/ros/world_markers.hpp"

namespace sim2sim {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;
using ::testing::SizeIs;
using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

constexpr double kTolerance = 1e-9;
constexpr double kSeen = 0.006;  // [m] by which one thing must be over another for rviz to tell from above

/// A world whose tee begins at `start`, whatever it is reset to, and drifts at constant rates, whatever the action.
class DriftingWorld : public pusht::BatchSimulator {
 public:
  DriftingWorld(Eigen::Vector2d start, double speed, double yaw_rate)
      : start_(std::move(start)), speed_(speed), yaw_rate_(yaw_rate) {}

  int lanes() const override { return 1; }
  void reset(int /*lane*/, const pusht::WorldState& /*state*/) override {
    state_ = {};
    state_.tee_position = start_;
  }
  void step(Actions /*actions*/) override {
    state_.tee_position.x() += speed_ * pusht::kControlStep;
    state_.tee_yaw = pusht::wrapAngle(state_.tee_yaw + yaw_rate_ * pusht::kControlStep);
  }
  pusht::WorldState state(int /*lane*/) const override { return state_; }

 private:
  Eigen::Vector2d start_;
  double speed_;
  double yaw_rate_;
  pusht::WorldState state_;
};

Picture picture() {
  return Picture({{{"mujoco", "MuJoCo, closed loop"},
                   {"engine", "engine, closed loop"},
                   {"engine_replay", "engine, replay of MuJoCo's actions"}}});
}

class IdlePolicy : public pusht::Policy {
 public:
  void act(pusht::Span<const Query> /*queries*/, pusht::Span<pusht::Action> actions) override {
    std::fill(actions.begin(), actions.end(), pusht::Action{0.0F, 0.0F});
  }
};

/// Episode 7, in which the tee of the reference rests and the engine's drift away.
class DriftingEpisode {
 public:
  DriftingEpisode(const Eigen::Vector2d& start, double replay_speed, double replay_yaw_rate,
                  double engine_speed = -0.02, int index = 7)
      : worlds_{std::make_unique<DriftingWorld>(start, 0.0, 0.0),
                std::make_unique<DriftingWorld>(start, engine_speed, 0.1),
                std::make_unique<DriftingWorld>(start, replay_speed, replay_yaw_rate)},
        flight_(protocol_, worlds_, policy_),
        episode_(flight_.begin(index)) {}

  void advance(int steps) {
    for (int k = 0; k < steps; ++k) {
      flight_.advance();
    }
  }

  MarkerArray update(const std::optional<Summary>& summary = std::nullopt,
                     std::optional<int> last = std::nullopt) const {
    return picture().update(run(), episode_, summary, last);
  }

  MarkerArray overlay() const { return picture().overlay(run(), episode_, std::nullopt, std::nullopt); }

 private:
  RunConfiguration run() const {
    RunConfiguration run;
    run.policy = "bc";
    run.protocol = protocol_;
    return run;
  }

  IdlePolicy policy_;
  Protocol protocol_;
  Worlds worlds_;
  Flight flight_;
  const Episode& episode_;
};

const Eigen::Vector2d kAway(0.2, 0.1);
const Eigen::Vector2d kOnTarget(0.0, 0.0);

Summary someSummary() {
  Summary summary;
  summary.episodes = 20;
  summary.reference = {12, 0.6, wilsonInterval(12, 20)};
  summary.engine = {4, 0.2, wilsonInterval(4, 20)};
  summary.means.resize(kModeCount);
  summary.yardsticks.resize(kModeCount);
  for (Yardstick& yardstick : summary.yardsticks[kEngineReplay]) {
    yardstick.minus_null = {-0.024, Interval{-0.03, -0.02}, 0.001};
  }
  auto& replay = summary.means[kEngineReplay];
  replay[quantityIndex("mean_position_divergence")] = {0.0821, Interval{0.0682, 0.0953}};
  replay[quantityIndex("mean_angle_divergence")] = {0.948, Interval{0.771, 1.126}};
  return summary;
}

std::vector<Marker> all(const MarkerArray& scene, const MarkerArray& update) {
  std::vector<Marker> markers = scene.markers;
  markers.insert(markers.end(), update.markers.begin(), update.markers.end());
  return markers;
}

/// The markers of one type that are drawn, not deleted, in the frame of a table.
std::vector<Marker> drawn(const MarkerArray& array, const std::string& prefix, int type) {
  std::vector<Marker> found;
  for (const Marker& marker : array.markers) {
    if (marker.header.frame_id == prefix + "/table" && marker.type == type && marker.action == Marker::ADD) {
      found.push_back(marker);
    }
  }
  return found;
}

std::vector<std::string> texts(const MarkerArray& array, const std::string& prefix) {
  std::vector<std::string> texts;
  for (const Marker& marker : drawn(array, prefix, Marker::TEXT_VIEW_FACING)) {
    texts.push_back(marker.text);
  }
  return texts;
}

std::set<std::pair<std::string, int>> names(const std::vector<Marker>& markers) {
  std::set<std::pair<std::string, int>> names;
  for (const Marker& marker : markers) {
    names.emplace(marker.ns, marker.id);
  }
  return names;
}

/// The rectangle between two axes: LINE_STRIPs of the scene from the top along the left to the right.
struct Axes {
  double left, right, bottom, top;
};
std::vector<Axes> axesBelow(const std::string& prefix) {
  std::vector<Axes> axes;
  for (const Marker& strip : drawn(picture().scene(), prefix, Marker::LINE_STRIP)) {
    const auto& points = strip.points;
    axes.push_back({points.at(1).x, points.at(2).x, points.at(1).y, points.at(0).y});
  }
  return axes;
}

/// The curves below a table: lines of an update that start at the lower left of some axes.
std::vector<Marker> curvesBelow(const MarkerArray& update, const std::string& prefix) {
  std::vector<Marker> curves;
  for (const Marker& strip : drawn(update, prefix, Marker::LINE_STRIP)) {
    for (const Axes& axes : axesBelow(prefix)) {
      if (strip.points.front().x == axes.left && strip.points.front().y == axes.bottom) {
        curves.push_back(strip);
      }
    }
  }
  return curves;
}

TEST(WorldMarkers, TheOutlineOfTheTeeHasTheCornersOfBarAndStem) {
  const std::vector<geometry_msgs::Point> outline = pusht::teeOutline();
  std::vector<std::pair<double, double>> corners;
  corners.reserve(outline.size());
  for (const geometry_msgs::Point& corner : outline) {
    corners.emplace_back(corner.x, corner.y);
  }
  EXPECT_EQ(corners.front(), corners.back()) << "closed";
  EXPECT_THAT(corners, SizeIs(9));
  for (const double side : {-1.0, 1.0}) {
    EXPECT_THAT(corners, IsSupersetOf(std::vector<std::pair<double, double>>{
                             {side * pusht::kBarHalfLength, pusht::kTeeHalfWidth},
                             {side * pusht::kBarHalfLength, -pusht::kTeeHalfWidth},
                             {side * pusht::kTeeHalfWidth, -pusht::kTeeHalfWidth},
                             {side * pusht::kTeeHalfWidth, -pusht::kStemOffset - pusht::kStemHalfLength}}));
  }
}

TEST(WorldMarkers, TheSurfaceOfTheTeeIsThatOfBarAndStem) {
  const std::vector<geometry_msgs::Point> corners = pusht::teeSurface();
  ASSERT_EQ(corners.size() % 3, 0U);
  double area = 0.0;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    const auto& [a, b, c] = std::tie(corners[i], corners[i + 1], corners[i + 2]);
    const double twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    EXPECT_GT(twice, 0.0) << "counterclockwise: it is seen from above";
    area += 0.5 * twice;
  }
  EXPECT_NEAR(area, 4.0 * pusht::kTeeHalfWidth * (pusht::kBarHalfLength + pusht::kStemHalfLength), kTolerance);
}

TEST(WorldMarkers, TheBodiesHaveTheSizesOfTheTaskAndStandOnTheTable) {
  const MarkerArray world = pusht::worldMarkers("mujoco");
  std::vector<Marker> tee;
  std::vector<Marker> pusher;
  for (const Marker& marker : world.markers) {
    if (marker.header.frame_id == "mujoco/tee") {
      tee.push_back(marker);
    } else if (marker.header.frame_id == "mujoco/pusher") {
      pusher.push_back(marker);
    }
  }
  ASSERT_THAT(tee, SizeIs(2));
  EXPECT_EQ(tee[0].scale.x, 2.0 * pusht::kBarHalfLength);
  EXPECT_EQ(tee[0].scale.y, 2.0 * pusht::kTeeHalfWidth);
  EXPECT_EQ(tee[0].scale.z, 2.0 * pusht::kTeeFrameHeight);
  EXPECT_EQ(tee[1].scale.x, 2.0 * pusht::kTeeHalfWidth);
  EXPECT_EQ(tee[1].scale.y, 2.0 * pusht::kStemHalfLength);
  EXPECT_EQ(tee[1].pose.position.y, -pusht::kStemOffset);
  ASSERT_THAT(pusher, SizeIs(1));
  EXPECT_EQ(pusher[0].type, static_cast<int>(Marker::CYLINDER));
  EXPECT_EQ(pusher[0].scale.x, 2.0 * pusht::kPusherRadius);
  EXPECT_EQ(pusher[0].scale.z, 2.0 * pusht::kPusherFrameHeight);
}

TEST(Picture, NoTwoMarkersShareAName) {
  DriftingEpisode episode(kAway, 0.02, 0.1);
  episode.advance(10);
  std::vector<Marker> markers = all(picture().scene(), episode.update());
  const MarkerArray overlay = episode.overlay();
  markers.insert(markers.end(), overlay.markers.begin(), overlay.markers.end());
  EXPECT_EQ(names(markers).size(), markers.size());
}

TEST(Picture, EveryMarkerMovesWithAFrameOfAWorld) {
  std::set<std::string> frames;
  for (const char* prefix : {"mujoco", "engine", "engine_replay"}) {
    for (const char* frame : {"/table", "/pusher", "/tee", "/target"}) {
      frames.insert(std::string(prefix) + frame);
    }
  }
  frames.insert({"overlay/table", "overlay/target", "overlay/card"});
  DriftingEpisode episode(kAway, 0.02, 0.1);
  episode.advance(10);
  std::set<std::string> used;
  std::vector<Marker> markers = all(picture().scene(), episode.update());
  const MarkerArray overlay = episode.overlay();
  markers.insert(markers.end(), overlay.markers.begin(), overlay.markers.end());
  for (const Marker& marker : markers) {
    used.insert(marker.header.frame_id);
    EXPECT_TRUE(marker.frame_locked);
    EXPECT_TRUE(marker.header.stamp.isZero());
  }
  EXPECT_EQ(used, frames);
}

TEST(Picture, AnUpdateIsSmallHoweverLongTheEpisode) {
  DriftingEpisode episode(kAway, 0.1, 0.1);
  for (int step = 0; step <= pusht::kHorizon; ++step) {
    EXPECT_LT(ros::serialization::serializationLength(episode.update(someSummary())), 40'000U) << "step " << step;
    episode.advance(1);
  }
}

TEST(Picture, CurvesRunFromCornerToCornerOfTheirAxes) {
  // After 4 s, the full width of the axes, the replay is 0.3 m and pi off, their full heights.
  DriftingEpisode episode(kAway, 0.3 / 4.0, -pusht::kPi / 4.0);
  episode.advance(40);
  const std::vector<Marker> curves = curvesBelow(episode.update(), "engine_replay");
  const std::vector<Axes> axes = axesBelow("engine_replay");
  ASSERT_THAT(curves, SizeIs(2));
  ASSERT_THAT(axes, SizeIs(2));
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_THAT(curves[i].points, SizeIs(41));
    for (std::size_t k = 0; k <= 40; ++k) {
      const double part = static_cast<double>(k) / 40.0;
      EXPECT_NEAR(curves[i].points[k].x, axes[i].left + part * (axes[i].right - axes[i].left), kTolerance);
      EXPECT_NEAR(curves[i].points[k].y, axes[i].bottom + part * (axes[i].top - axes[i].bottom), kTolerance);
    }
  }
}

TEST(Picture, LongCurvesKeepTheirPeaks) {
  constexpr double kYawRate = 1.0;
  DriftingEpisode episode(kAway, 0.0, kYawRate);
  episode.advance(pusht::kHorizon);
  const Marker angle = curvesBelow(episode.update(), "engine_replay").back();
  const Axes axes = axesBelow("engine_replay").back();
  const double step = (axes.right - axes.left) / pusht::kHorizon;
  EXPECT_LT(angle.points.size(), 80U);
  EXPECT_NEAR(angle.points.front().x, axes.left, kTolerance);
  EXPECT_NEAR(angle.points.back().x, axes.right, kTolerance);
  for (int k = 0; k <= pusht::kHorizon; ++k) {
    const double part = std::abs(pusht::wrapAngle(k * kYawRate * pusht::kControlStep)) / pusht::kPi;
    double highest = axes.bottom;
    for (const geometry_msgs::Point& point : angle.points) {
      if (std::abs(point.x - (axes.left + k * step)) < 5.5 * step) {
        highest = std::max(highest, point.y);
      }
    }
    EXPECT_GE(highest, axes.bottom + part * (axes.top - axes.bottom) - 1e-6) << "step " << k;
  }
}

TEST(Picture, CurvesStayInTheirAxes) {
  DriftingEpisode episode(kAway, 1.0, 1.0);
  for (const int steps : {1, 40, 1, 59, 199}) {
    episode.advance(steps);
    const MarkerArray update = episode.update();
    for (const char* prefix : {"mujoco", "engine", "engine_replay"}) {
      const std::vector<Axes> axes = axesBelow(prefix);
      for (const Marker& curve : curvesBelow(update, prefix)) {
        for (const geometry_msgs::Point& point : curve.points) {
          EXPECT_GE(point.x, axes[0].left);
          EXPECT_LE(point.x, axes[0].right + kTolerance);
          EXPECT_LE(point.y, axes[0].top);
          EXPECT_GE(point.y, axes[1].bottom);
        }
      }
    }
  }
}

TEST(Picture, ALongCurveKeepsItsEnd) {
  DriftingEpisode episode(kAway, 0.01, 0.0);
  episode.advance(pusht::kHorizon);
  const Marker curve = curvesBelow(episode.update(), "engine_replay").at(0);
  const Axes axes = axesBelow("engine_replay").at(0);
  EXPECT_NEAR(curve.points.back().x, axes.right, kTolerance);
  EXPECT_NEAR(curve.points.back().y, axes.top, kTolerance) << "0.01 m/s for 30 s";
}

TEST(Picture, TheReferenceHasTheCurvesOfBothOthers) {
  DriftingEpisode episode(kAway, 0.02, 0.1);
  episode.advance(10);
  const MarkerArray update = episode.update();
  EXPECT_THAT(curvesBelow(update, "mujoco"), SizeIs(4));
  EXPECT_THAT(curvesBelow(update, "engine"), SizeIs(2));
  EXPECT_THAT(curvesBelow(update, "engine_replay"), SizeIs(2));
}

TEST(Picture, TheGhostIsTheTeeOfTheReference) {
  const MarkerArray update = DriftingEpisode(kAway, 0.02, 0.1).update();
  EXPECT_THAT(drawn(update, "mujoco", Marker::TRIANGLE_LIST), IsEmpty());
  EXPECT_THAT(drawn(update, "engine", Marker::TRIANGLE_LIST), IsEmpty());
  const std::vector<Marker> ghost = drawn(update, "engine_replay", Marker::TRIANGLE_LIST);
  ASSERT_THAT(ghost, SizeIs(1));
  EXPECT_EQ(ghost[0].pose.position.x, kAway.x());
  EXPECT_EQ(ghost[0].pose.position.y, kAway.y());
  EXPECT_EQ(ghost[0].pose.orientation.w, 1.0);
}

TEST(Picture, SaysWhatTheFinishedEpisodesSay) {
  const DriftingEpisode episode(kAway, 0.02, 0.1);
  EXPECT_THAT(texts(episode.update(), "mujoco"), Not(Contains(HasSubstr("success"))));
  const MarkerArray update = episode.update(someSummary());
  EXPECT_THAT(texts(update, "mujoco"), IsSupersetOf({"success 12/20 = 0.60", "95% interval [0.39, 0.78]"}));
  EXPECT_THAT(texts(update, "engine"), IsSupersetOf({"success 4/20 = 0.20", "95% interval [0.08, 0.42]"}));
  EXPECT_THAT(texts(update, "engine_replay"),
              IsSupersetOf({"divergence 0.082 m, 0.95 rad", "95% intervals [0.068, 0.095] m, [0.77, 1.13] rad"}));
}

TEST(Picture, MarksADivergenceThatDoesNotBeatTheNullModel) {
  Summary summary = someSummary();
  summary.yardsticks[kEngineReplay][1].minus_null = {0.01, Interval{-0.1, 0.12}, 0.8};
  EXPECT_THAT(texts(DriftingEpisode(kAway, 0.02, 0.1).update(summary), "engine_replay"),
              Contains("divergence 0.082 m, 0.95 rad (!)"));
}

TEST(Picture, SaysWhereTheRunIs) {
  DriftingEpisode episode(kAway, 0.02, 0.1);
  episode.advance(143);
  const MarkerArray update = episode.update();
  EXPECT_THAT(texts(update, "engine"), Contains("policy bc, episode 7, 14.3 s"));
  EXPECT_THAT(texts(update, "mujoco"), IsSupersetOf({"0.224 m, 0.00 rad off target", "0", "10", "20 s"}));
  EXPECT_THAT(texts(update, "engine_replay"), Contains("0.286"));
}

TEST(Picture, SaysThatTheRunHasFinishedAtTheEndOfTheEpisodeThatWasTheLast) {
  constexpr int kLast = 19;  // of 50 that were asked for: the run was decided
  DriftingEpisode episode(kAway, 0.0, 0.0, 0.0, kLast);
  const Summary summary = someSummary();
  EXPECT_THAT(texts(episode.update(summary, kLast), "engine"), Contains("policy bc, episode 19, 0.0 s"))
      << "of a replay";
  episode.advance(pusht::kHorizon);
  EXPECT_THAT(texts(episode.update(summary), "engine"), Contains("policy bc, episode 19, 30.0 s")) << "it goes on";
  EXPECT_THAT(texts(episode.update(summary, kLast), "engine"), Contains("policy bc: finished, 20 episodes"));
  DriftingEpisode earlier(kAway, 0.0, 0.0, 0.0, kLast - 1);
  earlier.advance(pusht::kHorizon);
  EXPECT_THAT(texts(earlier.update(summary, kLast), "engine"), Contains("policy bc, episode 18, 30.0 s"))
      << "of a replay";
}

TEST(Picture, MarksWhereAWorldLeavesTheBound) {
  // The replay drifts by 0.02 m a step: after two steps it is beyond 0.03 m.
  DriftingEpisode episode(kAway, 0.2, 0.0, 0.0);
  episode.advance(1);
  EXPECT_THAT(texts(episode.update(), "engine_replay"), Not(Contains(HasSubstr("parts at"))));
  episode.advance(9);
  const MarkerArray update = episode.update();
  EXPECT_THAT(texts(update, "engine_replay"), Contains(HasSubstr("parts at 0.2 s: ")));
  EXPECT_THAT(texts(update, "engine"), Not(Contains(HasSubstr("parts at"))));
  const Axes axes = axesBelow("engine_replay").at(0);
  const double at = axes.left + 2.0 / 40.0 * (axes.right - axes.left);
  int marks = 0;
  for (const Marker& lines : drawn(update, "engine_replay", Marker::LINE_LIST)) {
    marks += lines.points.size() == 4 && std::abs(lines.points[0].x - at) < kTolerance ? 1 : 0;
  }
  EXPECT_EQ(marks, 1) << "one line through both diagrams";
}

TEST(Picture, TheWayOfATeeGetsBrighterWithTime) {
  DriftingEpisode episode(kAway, 0.2, 0.0);
  episode.advance(10);
  bool found = false;
  for (const Marker& way : drawn(episode.update(), "engine_replay", Marker::LINE_STRIP)) {
    if (!way.colors.empty()) {
      found = true;
      ASSERT_EQ(way.colors.size(), way.points.size());
      EXPECT_LT(way.colors.front().r, 0.5F * way.colors.back().r);
      EXPECT_EQ(way.colors.back().r, way.color.r);
    }
  }
  EXPECT_TRUE(found);
}

TEST(Picture, TheOverlayHasAllWorldsOnOneTable) {
  DriftingEpisode episode(kAway, 0.1, 0.0, -0.1);
  episode.advance(10);
  const std::vector<Marker> tees = drawn(episode.overlay(), "overlay", Marker::TRIANGLE_LIST);
  ASSERT_THAT(tees, SizeIs(3));
  EXPECT_EQ(tees[kReferenceClosed].color.a, 1.0F) << "solid";
  EXPECT_LT(tees[kEngineClosed].color.a, 0.5F);
  EXPECT_LT(tees[kEngineReplay].color.a, 0.5F);
  EXPECT_NEAR(tees[kReferenceClosed].pose.position.x, kAway.x(), kTolerance);
  EXPECT_NEAR(tees[kEngineClosed].pose.position.x, kAway.x() - 0.1, kTolerance);
  EXPECT_NEAR(tees[kEngineReplay].pose.position.x, kAway.x() + 0.1, kTolerance);
}

TEST(Picture, SaysWhyCurvesEnd) {
  DriftingEpisode episode(kOnTarget, 0.02, 0.0, -1.0);
  episode.advance(pusht::kSuccessHold);
  EXPECT_THAT(texts(episode.update(), "engine"), Not(Contains(HasSubstr("has succeeded"))));
  episode.advance(1);
  for (const char* prefix : {"mujoco", "engine", "engine_replay"}) {
    EXPECT_THAT(texts(episode.update(), prefix), Contains("from 0.5 s: the reference has succeeded"));
  }
}

TEST(Picture, TellsAReferenceFromAnEngineOfItsKind) {
  RunConfiguration run;
  run.reference.title = "MuJoCo";
  run.engine.title = "two-mass engine";
  const auto titles = [&](const char* prefix) {
    return texts(Picture::of(run, {"reference", "engine", "engine_replay"}).scene(), prefix);
  };
  EXPECT_THAT(titles("reference"), Contains("MuJoCo, closed loop"));
  run.reference.title = run.engine.title;
  EXPECT_THAT(titles("reference"), Contains("two-mass engine, reference"));
  EXPECT_THAT(titles("engine"), Contains("two-mass engine, closed loop"));
  EXPECT_THAT(titles("engine_replay"), Contains("two-mass engine, replay"));
}

TEST(Picture, APusherThatLeavesItsTablePassesBelowTheTexts) {
  const MarkerArray update = DriftingEpisode(kAway, 0.02, 0.1).update(someSummary());
  for (const char* prefix : {"mujoco", "engine", "engine_replay"}) {
    std::vector<Marker> cards;
    for (const Marker& cube : drawn(picture().scene(), prefix, Marker::CUBE)) {
      if (cube.pose.position.z >= 2.0 * pusht::kPusherFrameHeight + kSeen) {
        cards.push_back(cube);
      }
    }
    MarkerArray whole;
    whole.markers = all(picture().scene(), update);
    for (const Marker& text : drawn(whole, prefix, Marker::TEXT_VIEW_FACING)) {
      const auto& at = text.pose.position;
      EXPECT_TRUE(std::any_of(cards.begin(), cards.end(), [&](const Marker& card) {
        const auto& center = card.pose.position;
        return std::abs(at.x - center.x) <= 0.5 * card.scale.x &&
               std::abs(at.y - center.y) + 0.5 * text.scale.z <= 0.5 * card.scale.y && at.z >= center.z + kSeen;
      })) << text.text;
    }
  }
}

TEST(Picture, TheTablesStandSideBySideAndTheirTargetsDoNotMove) {
  std::vector<std::string> children;
  for (const geometry_msgs::TransformStamped& frame : picture().frames()) {
    children.push_back(frame.child_frame_id);
    EXPECT_EQ(frame.transform.rotation.w, 1.0);
  }
  EXPECT_THAT(children,
              ElementsAre("mujoco/table", "mujoco/target", "engine/table", "engine/target", "engine_replay/table",
                          "engine_replay/target", "overlay/table", "overlay/target", "overlay/card"));
}

TEST(Picture, MarksSuccess) {
  DriftingEpisode episode(kOnTarget, 0.02, 0.0);
  episode.advance(pusht::kSuccessHold);
  const MarkerArray update = episode.update();
  EXPECT_THAT(texts(update, "mujoco"), Contains("success: 0.000 m, 0.00 rad off target"));
  EXPECT_THAT(drawn(update, "mujoco", Marker::LINE_LIST), SizeIs(2)) << "around the table, and the tolerance";
}

TEST(Picture, ANewEpisodeClearsWhatTheOldOneLeft) {
  DriftingEpisode old_episode(kOnTarget, 0.02, 0.0);
  old_episode.advance(pusht::kSuccessHold);
  const MarkerArray before = old_episode.update(someSummary());
  const MarkerArray after = DriftingEpisode(kAway, 0.02, 0.1).update();

  EXPECT_EQ(names(after.markers), names(before.markers)) << "each marker is replaced, or deleted";
  for (const char* prefix : {"mujoco", "engine"}) {
    EXPECT_GT(drawn(before, prefix, Marker::LINE_STRIP).size(), 2U);
    EXPECT_GT(drawn(before, prefix, Marker::LINE_LIST).size(), 1U);
    EXPECT_THAT(drawn(after, prefix, Marker::LINE_STRIP), SizeIs(2)) << "the ring of the tolerance, the tee's stem";
    EXPECT_THAT(drawn(after, prefix, Marker::LINE_LIST), SizeIs(1)) << "the sides of the tolerance";
  }
  EXPECT_THAT(drawn(after, "engine_replay", Marker::LINE_STRIP), SizeIs(3)) << "the ghost's outline, too";
}

TEST(Picture, DrawsTheWorldsOfTheUser) {
  const Picture mine({{{"sim", "My simulator"}, {"b", "B"}, {"c", "C"}}});
  EXPECT_THAT(texts(mine.scene(), "sim"), Contains("My simulator"));
}

}  // namespace
}  // namespace sim2sim
