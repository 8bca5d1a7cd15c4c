// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/contact.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"

namespace pusht {
namespace {

using Eigen::Vector2d;
using ::testing::ThrowsMessage;

constexpr double kRounding = 1e-12;  // [m, m/s]

/// Where a tee's frame is on the table.
struct Place {
  Vector2d position;
  double yaw;
};

const std::vector<Place> kPlaces = {
    {{0.0, 0.0}, 0.0}, {{0.1, -0.2}, 0.7}, {{-0.15, 0.05}, -2.9}, {{0.2, 0.2}, kPi / 2.0}, {{0.0, 0.1}, -kPi},
};

/// At rest; the pusher is given in the tee's frame.
WorldState worldWith(const Vector2d& pusher, const Place& place = {{0.0, 0.0}, 0.0}) {
  WorldState state;
  state.tee_position = place.position;
  state.tee_yaw = place.yaw;
  state.pusher_position = place.position + Eigen::Rotation2Dd(place.yaw) * pusher;
  return state;
}

/// What is nearest to the pusher on a box, in the tee's frame.
struct Near {
  Vector2d point;
  Vector2d way;  // to the pusher's center
  double gap;
};

struct Case {
  const char* name;
  Part part;
  Vector2d pusher;  // in the tee's frame
  Near bar;
  Near stem;
};

/// The bar reaches from (-0.06, -0.015) to (0.06, 0.015), the stem from (-0.015, -0.105) to (0.015, -0.015). A pusher
/// that touches has its center 0.015 from there. Where it is far from a box, its gap follows from the way.
std::vector<Case> cases() {
  const auto far = [](const Vector2d& point, const Vector2d& way) { return Near{point, way, way.norm() - 0.015}; };
  const Vector2d right(0.015, -0.015);  // the stem's upper corners
  const Vector2d left(-0.015, -0.015);
  return {
      {"on the bar", Part::kBar, {0.05, 0.03}, {{0.05, 0.015}, {0, 1}, 0.0}, far(right, {0.035, 0.045})},
      {"1 mm in it", Part::kBar, {-0.02, 0.029}, {{-0.02, 0.015}, {0, 1}, -0.001}, far(left, {-0.005, 0.044})},
      {"at its tip", Part::kBar, {-0.075, 0.0}, {{-0.06, 0.0}, {-1, 0}, 0.0}, far(left, {-0.06, 0.015})},
      {"at its corner", Part::kBar, {0.069, 0.027}, {{0.06, 0.015}, {0.6, 0.8}, 0.0}, far(right, {0.054, 0.042})},
      {"inside, near the top", Part::kBar, {0.02, 0.004}, {{0.02, 0.015}, {0, 1}, -0.026}, far(right, {0.005, 0.019})},
      {"inside, near the tip", Part::kBar, {-0.055, 0.0}, {{-0.06, 0.0}, {-1, 0}, -0.02}, far(left, {-0.04, 0.015})},
      {"beside the stem", Part::kStem, {0.03, -0.08}, far({0.03, -0.015}, {0, -0.065}), {{0.015, -0.08}, {1, 0}, 0.0}},
      {"below it", Part::kStem, {0.01, -0.12}, far({0.01, -0.015}, {0, -0.105}), {{0.01, -0.105}, {0, -1}, 0.0}},
      {"at its corner",
       Part::kStem,
       {-0.027, -0.114},
       far({-0.027, -0.015}, {0, -0.099}),
       {{-0.015, -0.105}, {-0.8, -0.6}, 0.0}},
      {"where they meet",
       Part::kCorner,
       {-0.03, -0.03},
       {{-0.03, -0.015}, {0, -1}, 0.0},
       {{-0.015, -0.03}, {-1, 0}, 0.0}},
      {"1 mm from both",
       Part::kNone,
       {0.031, -0.031},
       {{0.031, -0.015}, {0, -1}, 0.001},
       {{0.015, -0.031}, {1, 0}, 0.001}},
  };
}

TEST(Contacts, AreWhereTheTaskHasTheBodies) {
  for (const Case& c : cases()) {
    for (const Place& place : kPlaces) {
      SCOPED_TRACE(::testing::Message() << c.name << ", yaw " << place.yaw);
      const Eigen::Rotation2Dd rotation(place.yaw);
      const Contacts contacts = contactsOf(worldWith(c.pusher, place));
      EXPECT_EQ(contacts.part(), c.part);
      for (const auto& [contact, near] : {std::pair(contacts.bar, c.bar), std::pair(contacts.stem, c.stem)}) {
        EXPECT_NEAR(contact.gap, near.gap, kRounding);
        EXPECT_LT((contact.point - place.position - rotation * near.point).norm(), kRounding);
        EXPECT_LT((contact.normal - rotation * near.way.normalized()).norm(), kRounding);
      }
    }
  }
}

TEST(Contacts, TouchUpToTheTolerance) {
  for (const Place& place : kPlaces) {
    const auto part_at = [&](double gap) { return contactsOf(worldWith({0.0, 0.03 + gap}, place)).part(); };
    EXPECT_EQ(part_at(-0.01), Part::kBar);
    EXPECT_EQ(part_at(0.9 * kContactTolerance), Part::kBar);
    EXPECT_EQ(part_at(1.1 * kContactTolerance), Part::kNone);
    EXPECT_EQ(part_at(0.01), Part::kNone);
  }
}

TEST(Contacts, HaveANormalWhereverThePusherIs) {
  for (const Vector2d& pusher : {Vector2d(0.0, 0.0), Vector2d(0.0, -kStemOffset), Vector2d(0.06, 0.015),
                                 Vector2d(0.0, std::nextafter(0.015, 1.0)), Vector2d(0.0, 0.015)}) {
    const Contacts contacts = contactsOf(worldWith(pusher));
    EXPECT_NEAR(contacts.bar.normal.norm(), 1.0, kRounding) << pusher.transpose();
    EXPECT_NEAR(contacts.stem.normal.norm(), 1.0, kRounding) << pusher.transpose();
  }
}

/// Slow and simple: the least distance to any of many points of a box's outline.
double distanceToOutline(const Vector2d& point, const Vector2d& center, double half_x, double half_y) {
  constexpr int kPoints = 2000;  // a side
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kPoints; ++i) {
    const double s = 2.0 * i / kPoints - 1.0;
    for (const double side : {-1.0, 1.0}) {
      least = std::min(least, (point - center - Vector2d(s * half_x, side * half_y)).norm());
      least = std::min(least, (point - center - Vector2d(side * half_x, s * half_y)).norm());
    }
  }
  return least;
}

TEST(Contacts, AgreeWithASearchAlongTheOutline) {
  NumpyGenerator random(7);
  const auto inside = [](const Vector2d& p, double half_x, double half_y) {
    return std::abs(p.x()) < half_x && std::abs(p.y()) < half_y;
  };
  int insides = 0;
  for (int i = 0; i < 200; ++i) {
    const Vector2d pusher(random.uniform(-0.1, 0.1), random.uniform(-0.15, 0.05));
    const Vector2d stem(0.0, -kStemOffset);
    const Contacts contacts = contactsOf(worldWith(pusher, kPlaces[static_cast<std::size_t>(i) % kPlaces.size()]));
    const bool in_bar = inside(pusher, kBarHalfLength, kTeeHalfWidth);
    const bool in_stem = inside(pusher - stem, kTeeHalfWidth, kStemHalfLength);
    const double to_bar = distanceToOutline(pusher, {0.0, 0.0}, kBarHalfLength, kTeeHalfWidth);
    const double to_stem = distanceToOutline(pusher, stem, kTeeHalfWidth, kStemHalfLength);
    EXPECT_NEAR(contacts.bar.gap + kPusherRadius, in_bar ? -to_bar : to_bar, 3e-5);  // half of the points' distance
    EXPECT_NEAR(contacts.stem.gap + kPusherRadius, in_stem ? -to_stem : to_stem, 3e-5);
    insides += in_bar || in_stem ? 1 : 0;
  }
  EXPECT_GT(insides, 10);
}

/// On the bar's top at (0.05, 0.015), where left of the normal is -x.
TEST(Slip, IsThatOfThePushersSurfaceAlongTheTees) {
  WorldState state = worldWith({0.05, 0.03});
  state.pusher_velocity = {0.3, -0.5};
  EXPECT_NEAR(contactsOf(state).bar.slip, -0.3, kRounding) << "the tee rests";
  state.tee_velocity = {0.3, -0.5};
  EXPECT_NEAR(contactsOf(state).bar.slip, 0.0, kRounding) << "they move as one";
  state.pusher_velocity = {0.0, 0.0};
  EXPECT_NEAR(contactsOf(state).bar.slip, 0.3, kRounding) << "the pusher rests";
  state.tee_velocity = {0.0, 0.0};
  state.tee_yaw_rate = 2.0;  // the point of contact moves with 2 (-0.015, 0.05)
  EXPECT_NEAR(contactsOf(state).bar.slip, -0.03, kRounding) << "the tee turns";
}

TEST(Slip, IsTheSameInATurnedAndMovedWorld) {
  for (const Place& place : kPlaces) {
    const Eigen::Rotation2Dd rotation(place.yaw);
    WorldState state = worldWith({0.03, -0.08}, place);  // beside the stem, where left of the normal is +y
    state.pusher_velocity = rotation * Vector2d(0.1, 0.25);
    state.tee_velocity = rotation * Vector2d(-0.2, 0.05);
    state.tee_yaw_rate = -4.0;  // the point of contact at (0.015, -0.08) moves with -4 (0.08, 0.015)
    EXPECT_NEAR(contactsOf(state).stem.slip, 0.25 - (0.05 - 0.06), kRounding);
  }
}

TEST(Slip, ChangesItsSignInAMirror) {
  WorldState right = worldWith({0.04, 0.03});
  right.pusher_velocity = {0.2, -0.1};
  right.tee_velocity = {0.05, 0.1};
  right.tee_yaw_rate = 1.5;
  WorldState left = right;
  for (Vector2d* vector : {&left.pusher_position, &left.pusher_velocity, &left.tee_position, &left.tee_velocity}) {
    vector->x() = -vector->x();
  }
  left.tee_yaw_rate = -left.tee_yaw_rate;
  EXPECT_NEAR(contactsOf(right).bar.gap, contactsOf(left).bar.gap, kRounding);
  EXPECT_NEAR(contactsOf(right).bar.slip, -contactsOf(left).bar.slip, kRounding);
  EXPECT_GT(std::abs(contactsOf(right).bar.slip), 0.1);
}

TEST(SlipDistance, AlongARestingTeeIsTheWay) {
  for (const Place& place : kPlaces) {
    EXPECT_NEAR(slipDistance(worldWith({0.01, 0.03}, place), worldWith({0.04, 0.03}, place), Part::kBar), -0.03,
                kRounding);
    EXPECT_NEAR(slipDistance(worldWith({0.03, -0.08}, place), worldWith({0.03, -0.05}, place), Part::kStem), 0.03,
                kRounding);
  }
}

TEST(SlipDistance, OfBodiesThatMoveAsOneIsZero) {
  EXPECT_NEAR(
      slipDistance(worldWith({0.01, 0.03}, {{0.0, 0.0}, 0.4}), worldWith({0.01, 0.03}, {{0.1, -0.1}, 0.4}), Part::kBar),
      0.0, kRounding);
}

/// The tee turns by a little; where the same point of it stays at the pusher, the pusher's surface slides by r dphi.
TEST(SlipDistance, KnowsThatThePusherDoesNotTurn) {
  for (const double yaw : {0.0, 0.7, kPi - 0.02}) {  // the last one turns beyond pi
    const Place before{{0.0, 0.0}, yaw};
    const Place after{{0.0, 0.0}, wrapAngle(yaw + 0.1)};
    const double turned = kPusherRadius * 0.1;
    EXPECT_NEAR(slipDistance(worldWith({0.02, 0.03}, before), worldWith({0.02, 0.03}, after), Part::kBar), turned,
                kRounding);
    EXPECT_NEAR(slipDistance(worldWith({0.02, 0.03}, before), worldWith({0.02 + turned, 0.03}, after), Part::kBar), 0.0,
                kRounding)
        << "it rolls";
  }
}

/// The slip of many moments in between sums up to the distance: on a face, round a corner, and on the other side of pi.
TEST(SlipDistance, IsTheSumOfTheSlipOnTheWay) {
  // Where the pusher touches the tee, in its frame, at time s from 0 to 1.
  const std::vector<std::pair<Part, std::function<Vector2d(double)>>> ways = {
      {Part::kBar, [](double s) { return Vector2d(-0.03 + 0.02 * s * s, 0.03); }},
      {Part::kBar,
       [](double s) {  // round the corner at (0.06, 0.015)
         const double angle = 0.3 + 0.9 * s;
         return Vector2d(0.06 + kPusherRadius * std::cos(angle), 0.015 + kPusherRadius * std::sin(angle));
       }},
      {Part::kStem, [](double s) { return Vector2d(-0.03, -0.04 - 0.03 * s); }},
  };
  const auto place_at = [](double s) { return Place{{0.1 + 0.05 * s, -0.02 * s * s}, 3.0 + 0.4 * s}; };
  constexpr int kMoments = 1000;
  constexpr double kApart = 1e-6;
  for (const auto& [part, way] : ways) {
    const auto state_at = [&, &way = way](double s) {
      const Place place = place_at(s);
      return worldWith(way(s), {place.position, wrapAngle(place.yaw)});
    };
    double sum = 0.0;
    for (int i = 0; i < kMoments; ++i) {
      const double s = (i + 0.5) / kMoments;
      WorldState state = state_at(s);
      const WorldState before = state_at(s - kApart);
      const WorldState after = state_at(s + kApart);
      state.pusher_velocity = (after.pusher_position - before.pusher_position) / (2.0 * kApart);
      state.tee_velocity = (after.tee_position - before.tee_position) / (2.0 * kApart);
      state.tee_yaw_rate = (place_at(s + kApart).yaw - place_at(s - kApart).yaw) / (2.0 * kApart);
      const Contacts contacts = contactsOf(state);
      sum += (part == Part::kBar ? contacts.bar : contacts.stem).slip / kMoments;
    }
    EXPECT_NEAR(slipDistance(state_at(0.0), state_at(1.0), part), sum, 1e-8);
    EXPECT_GT(std::abs(sum), 0.01);
  }
}

TEST(SlipDistance, ToTheOtherSideIsFinite) {
  EXPECT_TRUE(std::isfinite(slipDistance(worldWith({0.03, -0.08}), worldWith({-0.03, -0.08}), Part::kStem)));
}

TEST(SlipDistance, IsThatOfABox) {
  const WorldState state = worldWith({0.0, 0.03});
  for (const Part part : {Part::kNone, Part::kCorner}) {
    EXPECT_THAT([&] { slipDistance(state, state, part); },
                ThrowsMessage<InternalError>("slipDistance: the part must be bar or stem"));
  }
}

TEST(Common, IsWhatBothTouch) {
  constexpr std::array kParts = {Part::kNone, Part::kBar, Part::kStem, Part::kCorner};
  for (const Part part : kParts) {
    EXPECT_EQ(common(part, part), part);
    EXPECT_EQ(common(part, Part::kCorner), part);
    EXPECT_EQ(common(Part::kCorner, part), part);
    EXPECT_EQ(common(part, Part::kNone), Part::kNone);
    EXPECT_EQ(common(Part::kNone, part), Part::kNone);
  }
  EXPECT_EQ(common(Part::kBar, Part::kStem), Part::kNone);
  EXPECT_EQ(common(Part::kStem, Part::kBar), Part::kNone);
}

/// The inner faces are at 0.39 m, so that the pusher touches one at 0.375 m.
TEST(WallGaps, OfThePusher) {
  WorldState state;
  for (const auto& [pusher, gap] : std::vector<std::pair<Vector2d, double>>{{{0.0, 0.0}, 0.375},
                                                                            {{0.375, 0.1}, 0.0},
                                                                            {{-0.375, 0.1}, 0.0},
                                                                            {{0.1, 0.375}, 0.0},
                                                                            {{0.1, -0.375}, 0.0},
                                                                            {{-0.2, 0.3}, 0.075},
                                                                            {{0.1, -1.0}, -0.625}}) {
    state.pusher_position = pusher;
    const WallGaps gaps = wallGapsOf(state);
    EXPECT_NEAR(gaps.pusher, gap, kRounding) << pusher.transpose();
    EXPECT_EQ(gaps.touches(), gap <= 0.0) << pusher.transpose();
  }
}

/// Geometry of a tee with yaw 0: the bar's ends are at x +-0.06, its top is at y 0.015 and the stem's end at y -0.105.
TEST(WallGaps, OfTheTee) {
  struct TeeCase {
    Place place;
    double gap;
  };
  const double diagonal = std::sqrt(0.5);
  for (const TeeCase& c : {
           TeeCase{{{0.0, 0.0}, 0.0}, 0.285},
           TeeCase{{{0.33, 0.0}, 0.0}, 0.0},
           TeeCase{{{-0.33, 0.0}, 0.0}, 0.0},
           TeeCase{{{0.0, 0.375}, 0.0}, 0.0},
           TeeCase{{{0.0, -0.285}, 0.0}, 0.0},
           TeeCase{{{0.285, 0.0}, kPi / 2.0}, 0.0},                     // the stem's end points to +x
           TeeCase{{{-0.285, 0.0}, -kPi / 2.0}, 0.0},                   // and to -x
           TeeCase{{{0.0, 0.285}, -kPi}, 0.0},                          // and to +y
           TeeCase{{{0.3, 0.0}, kPi / 4.0}, 0.09 - 0.12 * diagonal},    // a corner of the stem's end, (0.015, -0.105)
           TeeCase{{{-0.3, 0.0}, kPi / 4.0}, 0.09 - 0.075 * diagonal},  // a corner of the bar, (-0.06, 0.015)
           TeeCase{{{0.3, 0.0}, -3.0 * kPi / 4.0}, 0.09 - 0.075 * diagonal},  // the same
           TeeCase{{{0.5, 0.0}, 0.0}, -0.17},
       }) {
    WorldState state = worldWith({0.0, 0.0}, c.place);
    state.pusher_position = {0.0, 0.0};
    const WallGaps gaps = wallGapsOf(state);
    EXPECT_NEAR(gaps.tee, c.gap, kRounding) << c.place.position.transpose() << ", " << c.place.yaw;
    EXPECT_EQ(gaps.touches(), c.gap <= 0.0) << c.place.position.transpose() << ", " << c.place.yaw;
  }
}

/// At a wall on the right, over all directions that the tee can have: the rightmost of its boxes' corners.
TEST(WallGaps, AreThoseOfTheFarthestCorner) {
  constexpr int kDirections = 60;
  for (int i = 0; i < kDirections; ++i) {
    const double yaw = wrapAngle(2.0 * kPi * i / kDirections);
    double rightmost = 0.0;
    for (const double side : {-1.0, 1.0}) {
      for (const Vector2d& corner : {Vector2d(side * 0.06, 0.015), Vector2d(side * 0.06, -0.015),
                                     Vector2d(side * 0.015, -0.015), Vector2d(side * 0.015, -0.105)}) {
        rightmost = std::max(rightmost, std::cos(yaw) * corner.x() - std::sin(yaw) * corner.y());
      }
    }
    EXPECT_NEAR(wallGapsOf(worldWith({0.0, 0.0}, {{0.25, 0.0}, yaw})).tee, 0.14 - rightmost, kRounding) << yaw;
  }
}

TEST(WallGaps, AreTheSameAtEveryWall) {
  const WorldState state = worldWith({0.05, 0.2}, {{0.1, -0.15}, 0.6});
  const WallGaps gaps = wallGapsOf(state);
  for (const double turn : {kPi / 2.0, kPi, -kPi / 2.0}) {
    WorldState turned = state;
    turned.pusher_position = Eigen::Rotation2Dd(turn) * state.pusher_position;
    turned.tee_position = Eigen::Rotation2Dd(turn) * state.tee_position;
    turned.tee_yaw = wrapAngle(state.tee_yaw + turn);
    EXPECT_NEAR(wallGapsOf(turned).pusher, gaps.pusher, kRounding);
    EXPECT_NEAR(wallGapsOf(turned).tee, gaps.tee, kRounding);
  }
}

}  // namespace
}  // namespace pusht
