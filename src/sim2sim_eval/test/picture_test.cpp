// SPDX-License-Identifier: BSD-3-Clause
#include "live/picture.hpp"

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

#include "live/captions.hpp"
#include "live/table_view.hpp"
#include "pusht_task/constants.hpp"
#include "sim2sim_protocol/ending.hpp"
#include "sim2sim_protocol/flight.hpp"
#include "sim2sim_serving/transforms.hpp"
#include "sim2sim_serving/world_markers.hpp"

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
  void spawn(int lane, std::uint64_t /*seed*/) override { reset(lane, {}); }
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
  return Picture({{{"mujoco", "MuJoCo, the reference", "policy bc"},
                   {"engine", "engine", "same policy"},
                   {"engine_replay", "engine", "same actions as MuJoCo"}}});
}

class ConstantPolicy : public pusht::Policy {
 public:
  explicit ConstantPolicy(const pusht::Action& action) : action_(action) {}

  void act(pusht::Span<const Query> /*queries*/, pusht::Span<pusht::Action> actions) override {
    std::fill(actions.begin(), actions.end(), action_);
  }

 private:
  pusht::Action action_;
};

/// Episode 7, in which the tee of the reference rests and the engine's drift away.
class DriftingEpisode {
 public:
  DriftingEpisode(const Eigen::Vector2d& start, double replay_speed, double replay_yaw_rate,
                  double engine_speed = -0.02, int index = 7, const pusht::Action& action = {0.0F, 0.0F})
      : policy_(action),
        worlds_{std::make_unique<DriftingWorld>(start, 0.0, 0.0),
                std::make_unique<DriftingWorld>(start, engine_speed, 0.1),
                std::make_unique<DriftingWorld>(start, replay_speed, replay_yaw_rate)},
        flight_(protocol_, worlds_, policy_, variants_),
        episode_(flight_.begin(index)) {}

  void advance(int steps) {
    for (int k = 0; k < steps; ++k) {
      flight_.advance();
    }
  }

  MarkerArray update(const std::optional<Summary>& summary = std::nullopt, const std::string& headline = "") const {
    return picture().update(run(), episode_, summary, headline);
  }

  MarkerArray overlay() const { return picture().overlay(run(), episode_, "headline"); }
  const Episode& episode() const { return episode_; }

 private:
  RunConfiguration run() const {
    RunConfiguration run;
    run.policy = "bc";
    run.protocol = protocol_;
    return run;
  }

  ConstantPolicy policy_;
  Protocol protocol_;
  Worlds worlds_;
  VariantWorlds variants_;
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
  summary.baselines.resize(kModeCount);
  for (BaselineComparison& baseline : summary.baselines[kEngineReplay]) {
    baseline.minus_null = {-0.024, Interval{-0.03, -0.02}, 0.001};
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

/// The markers of one type that are drawn, not deleted, in the frame of a view.
std::vector<Marker> drawn(const MarkerArray& array, const std::string& prefix, int type) {
  std::vector<Marker> found;
  for (const Marker& marker : array.markers) {
    if (marker.header.frame_id == prefix + "/window" && marker.type == type && marker.action == Marker::ADD) {
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

std::set<std::pair<std::string, int>> markerNames(const std::vector<Marker>& markers) {
  std::set<std::pair<std::string, int>> names;
  for (const Marker& marker : markers) {
    names.emplace(marker.ns, marker.id);
  }
  return names;
}

/// The window of a world, in the frame of its canvas, as its edge is drawn.
struct Edges {
  double left, right, bottom, top;
};
Edges edgesOf(const MarkerArray& update, const std::string& prefix) {
  for (const Marker& strip : drawn(update, prefix, Marker::LINE_STRIP)) {
    const auto& points = strip.points;
    return {points.at(0).x, points.at(2).x, points.at(0).y, points.at(2).y};
  }
  ADD_FAILURE() << prefix << " has no window";
  return {};
}

/// Middle of the triangles of a color.
std::optional<Eigen::Vector2d> middleOf(const MarkerArray& update, const std::string& prefix,
                                        const std_msgs::ColorRGBA& color) {
  for (const Marker& surface : drawn(update, prefix, Marker::TRIANGLE_LIST)) {
    if (surface.color == color) {
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();
      for (const geometry_msgs::Point& corner : surface.points) {
        sum += Eigen::Vector2d(corner.x, corner.y);
      }
      return sum / static_cast<double>(surface.points.size());
    }
  }
  return std::nullopt;
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

/// gym-pusht's table: walls at 5 and 506 px less their radius of 2 and the pusher's middle, the target at 45 degrees.
TEST(WorldMarkers, ShowTheTaskAtHand) {
  const MarkerArray world = pusht::worldMarkers("gym", pusht::gymPusht());
  const Marker& table = world.markers.at(0);
  EXPECT_NEAR(table.pose.position.x, -0.0005, kTolerance);
  EXPECT_NEAR(table.pose.position.y, 0.0005, kTolerance);
  EXPECT_NEAR(table.scale.x, 0.497, kTolerance);
  const geometry_msgs::TransformStamped target = pusht::targetFrame("gym", pusht::gymPusht().target);
  EXPECT_NEAR(target.transform.rotation.z, std::sin(-pusht::kPi / 8.0), kTolerance);
  EXPECT_NEAR(target.transform.translation.x, -0.015 * std::sqrt(0.5), kTolerance);
}

TEST(Captions, SayHowMuchIsCoveredWhereThatCounts) {
  pusht::Caption caption;
  caption.task = pusht::gymPusht();
  caption.moment = {7, 3, pusht::stateAtTarget(pusht::gymPusht())};
  const MarkerArray markers = pusht::captionMarkers("gym", caption);
  EXPECT_TRUE(std::any_of(markers.markers.begin(), markers.markers.end(),
                          [](const Marker& marker) { return marker.text == "covers 1.00 of the target"; }));
}

TEST(Picture, StandsItsTargetWhereTheTaskHasIt) {
  const Picture of_gym({{{"a", "A"}, {"b", "B"}, {"c", "C"}}}, pusht::gymPusht());
  for (const geometry_msgs::TransformStamped& frame : of_gym.frames()) {
    if (frame.child_frame_id == "b/target") {
      EXPECT_NEAR(frame.transform.rotation.w, std::cos(-pusht::kPi / 8.0), kTolerance);
      return;
    }
  }
  FAIL() << "no frame b/target";
}

TEST(Picture, NoTwoMarkersShareAName) {
  DriftingEpisode episode(kAway, 0.02, 0.1);
  episode.advance(10);
  std::vector<Marker> markers = all(picture().scene(), episode.update());
  const MarkerArray overlay = episode.overlay();
  markers.insert(markers.end(), overlay.markers.begin(), overlay.markers.end());
  EXPECT_EQ(markerNames(markers).size(), markers.size());
}

TEST(Picture, EveryMarkerStandsInAFrameThatDoesNotMove) {
  std::set<std::string> fixed;
  for (const geometry_msgs::TransformStamped& frame : picture().frames()) {
    fixed.insert(frame.child_frame_id);
  }
  DriftingEpisode episode(kAway, 0.02, 0.1);
  episode.advance(10);
  std::vector<Marker> markers = all(picture().scene(), episode.update());
  const MarkerArray overlay = episode.overlay();
  markers.insert(markers.end(), overlay.markers.begin(), overlay.markers.end());
  for (const Marker& marker : markers) {
    EXPECT_THAT(fixed, Contains(marker.header.frame_id)) << "what TF moves would be ahead of what a message moves";
    EXPECT_TRUE(marker.header.stamp.isZero());
  }
}

TEST(Picture, AnUpdateIsSmallHoweverLongTheEpisode) {
  DriftingEpisode episode(kAway, 0.1, 0.1);
  for (int step = 0; step <= pusht::kHorizon; ++step) {
    EXPECT_LT(ros::serialization::serializationLength(episode.update(someSummary())), 40'000U) << "step " << step;
    episode.advance(1);
  }
}

TEST(Picture, NothingIsDrawnBeyondTheEdgesOfAWindow) {
  DriftingEpisode episode(kAway, 1.0, 1.0, -1.0);
  for (const int steps : {0, 1, 3, 10, 100}) {
    episode.advance(steps);
    const MarkerArray update = episode.update();
    for (const char* prefix : {"mujoco", "engine", "engine_replay"}) {
      const Edges edges = edgesOf(update, prefix);
      for (const int type : {Marker::TRIANGLE_LIST, Marker::LINE_LIST, Marker::ARROW}) {
        for (const Marker& marker : drawn(update, prefix, type)) {
          for (const geometry_msgs::Point& point : marker.points) {
            EXPECT_GE(point.x, edges.left - kTolerance);
            EXPECT_LE(point.x, edges.right + kTolerance);
            EXPECT_GE(point.y, edges.bottom - kTolerance);
            EXPECT_LE(point.y, edges.top + kTolerance);
          }
        }
      }
    }
  }
}

TEST(Picture, EveryWorldShowsWhatItsPusherIsTold) {
  DriftingEpisode episode(kAway, 0.02, 0.0, -0.02, 7, {0.3F, 0.0F});
  const auto arrows = [&](const char* prefix) { return drawn(episode.update(), prefix, Marker::ARROW); };
  for (const char* prefix : {"mujoco", "engine", "engine_replay"}) {
    EXPECT_THAT(arrows(prefix), IsEmpty()) << prefix << " has not been told anything";
  }
  episode.advance(3);
  for (const char* prefix : {"mujoco", "engine", "engine_replay"}) {
    EXPECT_THAT(arrows(prefix), SizeIs(1)) << prefix << ": the command alone, since no pusher moves";
  }
  episode.advance(pusht::kHorizon);
  for (const char* prefix : {"mujoco", "engine", "engine_replay"}) {
    EXPECT_THAT(arrows(prefix), IsEmpty()) << prefix << " has come to its end";
  }
}

TEST(Picture, MagnifiesWhereThingsHappenAndNeverShrinksItsRegion) {
  DriftingEpisode episode({0.12, 0.05}, 0.05, 0.0);
  const Pane pane{{0.0, 0.0}, {0.92, 1.1}};
  EXPECT_GE(TableView(pane, regionOf(episode.episode(), pane)).zoom(), 1.9) << "the tees are near the target";
  double zoom = 10.0;
  for (int step = 0; step < 100; ++step) {
    const Region region = regionOf(episode.episode(), pane);
    const TableView view(pane, region);
    EXPECT_LE(view.zoom(), zoom + kTolerance);
    zoom = view.zoom();
    for (const Mode mode : {kReferenceClosed, kEngineClosed, kEngineReplay}) {
      for (const pusht::WorldState& state : episode.episode().rollout(mode).trace().states) {
        EXPECT_TRUE(view.shows(state.tee_position) || isOffTable(state)) << "step " << step;
      }
    }
    episode.advance(1);
  }
  EXPECT_GE(zoom, 0.92 / 0.9 - kTolerance) << "the replay has left the table: no more than all of it is seen";
}

TEST(Picture, ATeeThatLeavesTheTableHasAMarkAtTheEdgeAndWords) {
  DriftingEpisode episode(kAway, 2.0, 0.0, 0.0);
  EXPECT_THAT(texts(episode.update(), "engine_replay"), Not(Contains(HasSubstr("off the table"))));
  episode.advance(10);
  const MarkerArray update = episode.update();
  EXPECT_THAT(texts(update, "engine_replay"), Contains("off the table: 2.202 m, 0.00 rad off target"));
  EXPECT_THAT(texts(update, "engine"), Not(Contains(HasSubstr("off the table"))));
  const std::optional<Eigen::Vector2d> mark = middleOf(update, "engine_replay", colorOf(kEngineReplay));
  ASSERT_TRUE(mark);
  const Edges edges = edgesOf(update, "engine_replay");
  EXPECT_GT(mark->x(), edges.right - 0.1) << "at the edge, toward the tee";
}

TEST(Picture, TheGhostIsTheTeeOfTheReference) {
  DriftingEpisode episode(kAway, 0.02, 0.1);
  episode.advance(20);  // they are elsewhere by then
  const MarkerArray update = episode.update();
  const auto ghost = middleOf(update, "engine_replay", colorOf(kReferenceClosed, kGhostOpacity));
  const auto tee = middleOf(update, "mujoco", colorOf(kReferenceClosed));
  ASSERT_TRUE(ghost && tee);
  EXPECT_TRUE(ghost->isApprox(*tee, kTolerance));
  EXPECT_FALSE(middleOf(update, "mujoco", colorOf(kReferenceClosed, kGhostOpacity)));
  EXPECT_FALSE(middleOf(update, "engine", colorOf(kReferenceClosed, kGhostOpacity)));
}

TEST(Picture, AsksAndAnswers) {
  const DriftingEpisode episode(kAway, 0.02, 0.1);
  const std::string headline = "Does the skill transfer? No: the engine keeps 31 % [30, 32] of MuJoCo's success.";
  EXPECT_THAT(texts(episode.update(std::nullopt, headline), "engine"),
              IsSupersetOf({"Does the skill transfer? ", "No: the engine keeps 31 % [30, 32] of MuJoCo's success."}));
  EXPECT_THAT(texts(episode.update(std::nullopt, "No episode yet."), "engine"), Contains("No episode yet."));
  EXPECT_THAT(texts(episode.overlay(), "overlay"), Contains("headline"));
  for (const int length : {20, 90, 130, 200}) {
    const MarkerArray update = episode.update(std::nullopt, "Does it? " + std::string(length, 'n'));
    for (const Marker& text : drawn(update, "engine", Marker::TEXT_VIEW_FACING)) {
      EXPECT_LT(kCharacterWidth * text.scale.z * static_cast<double>(text.text.size()), 2.88)
          << "it fits on the screen";
    }
  }
}

TEST(Picture, WaitingPausedAndEndedAreShown) {
  for (const RunState state :
       {RunState::kWaits, RunState::kRuns, RunState::kPaused, RunState::kFinished, RunState::kEnded}) {
    const MarkerArray markers = stateMarkers(state, "waits for /engine");
    std::set<std::string> said;
    for (const Marker& marker : markers.markers) {
      EXPECT_EQ(marker.header.frame_id, "world") << "there are no frames of worlds yet";
      said.insert(marker.text);
    }
    EXPECT_THAT(said, Contains("waits for /engine"));
  }
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
  summary.baselines[kEngineReplay][1].minus_null = {0.01, Interval{-0.1, 0.12}, 0.8};
  EXPECT_THAT(texts(DriftingEpisode(kAway, 0.02, 0.1).update(summary), "engine_replay"),
              Contains("divergence 0.082 m, 0.95 rad (!)"));
}

TEST(Picture, SaysHowFarTheTeesAreFromTheTarget) {
  DriftingEpisode episode(kAway, 0.02, 0.1);
  episode.advance(143);
  EXPECT_THAT(texts(episode.update(), "mujoco"), Contains("0.224 m, 0.00 rad off target"));
  episode.advance(pusht::kHorizon - 143);
  EXPECT_THAT(texts(episode.update(), "mujoco"), Contains("stuck since 0.0 s: 0.224 m, 0.00 rad off target"));
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
}

TEST(Picture, TheWayOfATeeGetsBrighterWithTime) {
  DriftingEpisode episode(kAway, 0.2, 0.0);
  episode.advance(10);
  bool found = false;
  for (const Marker& way : drawn(episode.update(), "engine_replay", Marker::LINE_LIST)) {
    if (!way.colors.empty()) {
      found = true;
      ASSERT_EQ(way.colors.size(), way.points.size());
      EXPECT_LT(way.colors.front().r, 0.5F * way.colors.back().r);
      EXPECT_EQ(way.colors.back().r, way.color.r);
    }
  }
  EXPECT_TRUE(found);
}

TEST(Picture, TheOverlayHasAllWorldsInOneWindow) {
  DriftingEpisode episode(kAway, 0.1, 0.0, -0.1);
  episode.advance(10);
  const MarkerArray overlay = episode.overlay();
  const auto reference = middleOf(overlay, "overlay", colorOf(kReferenceClosed));
  const auto engine = middleOf(overlay, "overlay", colorOf(kEngineClosed, kGhostOpacity));
  const auto replay = middleOf(overlay, "overlay", colorOf(kEngineReplay, kGhostOpacity));
  ASSERT_TRUE(reference && engine && replay);
  EXPECT_LT(engine->x(), reference->x());
  EXPECT_GT(replay->x(), reference->x());
}

TEST(Picture, TellsWhoActsInEachWorld) {
  RunConfiguration run;
  run.policy = "bc";
  run.reference.title = "MuJoCo";
  run.engine.title = "two-mass engine";
  const auto titles = [&](const char* prefix) {
    return texts(Picture::of(run, {"reference", "engine", "engine_replay"}).scene(), prefix);
  };
  EXPECT_THAT(titles("reference"), IsSupersetOf({"MuJoCo, the reference", "policy bc"}));
  EXPECT_THAT(titles("engine"), IsSupersetOf({"two-mass engine", "same policy"}));
  EXPECT_THAT(titles("engine_replay"), IsSupersetOf({"two-mass engine", "same actions as MuJoCo"}));
  run.reference.title = run.engine.title;
  EXPECT_THAT(titles("reference"), Contains("two-mass engine, the reference"));
  EXPECT_THAT(titles("engine_replay"), Contains("same actions as the reference"));
}

TEST(Picture, TheLoopIsOfTheWorldThatThePolicyDrives) {
  RunConfiguration run;
  run.engine.parameters = {{"block_damp", 20.0}, {"loop.action_delay", 1}};
  run.engine.changed = {"block_damp", "loop.action_delay"};
  const Picture picture = Picture::of(run, {"reference", "engine", "engine_replay"});
  EXPECT_THAT(texts(picture.scene(), "engine"), IsSupersetOf({"block_damp 20.0", "loop.action_delay 1"}));
  EXPECT_THAT(texts(picture.scene(), "engine_replay"), Contains("block_damp 20.0"));
  EXPECT_THAT(texts(picture.scene(), "engine_replay"), Not(Contains("loop.action_delay 1")));
}

TEST(Picture, SettingsThatDoNotFitAreCounted) {
  SimulatorRecord simulator;
  for (const char* name : {"servo", "pusher_inertia", "tee_inertia", "shape", "drag", "friction", "walls", "coulomb"}) {
    simulator.parameters[name] = false;
    simulator.changed.emplace_back(name);
  }
  EXPECT_THAT(changedParameters(simulator, 2, 52),
              ElementsAre("servo false, pusher_inertia false", "tee_inertia false, shape false, and 4 more"));
  EXPECT_THAT(changedParameters(simulator, 9, 52), SizeIs(4));
  EXPECT_THAT(changedParameters({}, 2, 52), IsEmpty());
}

TEST(Picture, TheTablesStandSideBySideAndTheirTargetsDoNotMove) {
  std::vector<std::string> children;
  for (const geometry_msgs::TransformStamped& frame : picture().frames()) {
    children.push_back(frame.child_frame_id);
    EXPECT_EQ(frame.transform.rotation.w, 1.0);
  }
  EXPECT_THAT(children, ElementsAre("mujoco/table", "mujoco/target", "mujoco/window", "engine/table", "engine/target",
                                    "engine/window", "engine_replay/table", "engine_replay/target",
                                    "engine_replay/window", "overlay/window"));
}

TEST(Picture, MarksSuccess) {
  DriftingEpisode episode(kOnTarget, 0.02, 0.0);
  const double before = drawn(episode.update(), "mujoco", Marker::LINE_STRIP).at(0).scale.x;
  episode.advance(pusht::kSuccessHold);
  const MarkerArray update = episode.update();
  EXPECT_THAT(texts(update, "mujoco"), Contains("success after 0.5 s (0.000 m, 0.00 rad off)"));
  const Marker edge = drawn(update, "mujoco", Marker::LINE_STRIP).at(0);
  EXPECT_EQ(edge.color, colorOf(kReferenceClosed));
  EXPECT_GT(edge.scale.x, before);
}

TEST(Picture, ANewEpisodeClearsWhatTheOldOneLeft) {
  DriftingEpisode old_episode(kOnTarget, 0.2, 0.0);
  old_episode.advance(pusht::kSuccessHold);
  const MarkerArray before = old_episode.update(someSummary(), "Does it?");
  const MarkerArray after = DriftingEpisode(kAway, 0.02, 0.1).update();
  EXPECT_EQ(markerNames(after.markers), markerNames(before.markers)) << "each marker is replaced, or deleted";
  for (const char* prefix : {"mujoco", "engine", "engine_replay"}) {
    EXPECT_THAT(texts(after, prefix), SizeIs(1)) << "how far the tee is";
  }
}

TEST(Picture, DrawsTheWorldsOfTheUser) {
  const Picture mine({{{"sim", "My simulator"}, {"b", "B"}, {"c", "C"}}});
  EXPECT_THAT(texts(mine.scene(), "sim"), Contains("My simulator"));
}

}  // namespace
}  // namespace sim2sim
