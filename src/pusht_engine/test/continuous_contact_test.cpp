// SPDX-License-Identifier: BSD-3-Clause
// Continuous contact: the swept disc against cases by hand and against samples of its path; fast bodies against closed
// forms; no overlap, and no stop where nothing is met.
#include "continuous_contact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rigid_body_testing.hpp"

namespace pusht::rigid_body {
namespace {

const Eigen::Vector2d kBarHalf(0.06, 0.015);
constexpr double kDisc = 0.015;
constexpr double kTight = 1e-6;  // [m] hard contacts give way by a millionth of what is missing

RigidBodyParameters continuously(RigidBodyParameters parameters) {
  parameters.continuous = true;
  return parameters;
}

/// Boxes, and nothing that pushes or slows but contact.
Model freeBodies(bool continuous, bool softness) {
  RigidBodyParameters parameters = allSimple();
  parameters.pusher_inertia = parameters.shape = parameters.tee_inertia = parameters.walls = true;
  parameters.softness = softness;
  parameters.continuous = continuous;
  Model model = modelOf(parameters);
  model.servo_gain = model.drag_rate = 0.0;
  return model;
}

/// [m] Greatest overlap of the task's shapes.
double overlapOf(const Bodies& bodies) {
  const Tee tee = teeOf(kCourseModel, bodies.positions);
  const Eigen::Vector2d pusher(bodies.positions[kPusherX], bodies.positions[kPusherY]);
  double most = -1.0;
  for (const Part& part : kCourseModel.parts) {
    const Eigen::Vector2d center = centerOf(part, tee);
    most = std::max(most, touchNearest(pusher, kPusherRadius, part.box, center, tee.heading, 0.0).depth);
    for (const double x : {part.box.half_x, -part.box.half_x}) {
      for (const double y : {part.box.half_y, -part.box.half_y}) {
        most = std::max(most, (center + tee.heading.toTable({x, y})).lpNorm<Eigen::Infinity>() - kWallInnerFace);
      }
    }
  }
  return std::max(most, pusher.lpNorm<Eigen::Infinity>() + kPusherRadius - kWallInnerFace);
}

/// The pusher above the middle of the bar, on the line through the tee's center of mass, on its way down.
Bodies headOn(double gap, double speed) {
  return {{0.0, 0.0, 0.0, 0.0, kTeeHalfWidth + kPusherRadius + gap}, {0.0, 0.0, 0.0, 0.0, -speed}};
}

TEST(SweepDisc, MeetsAFace) {
  const auto hit = sweepDisc({0.01, 0.05}, {0.03, -0.05}, kDisc, kBarHalf);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance, 0.02, 1e-15);
  EXPECT_NEAR((hit->normal - Eigen::Vector2d(0.0, 1.0)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((hit->center - Eigen::Vector2d(0.014, 0.03)).norm(), 0.0, 1e-15);
}

TEST(SweepDisc, MeetsACorner) {
  const double away = 0.015 / std::sqrt(2.0);
  const auto hit = sweepDisc({0.06 + 3.0 * away, 0.015 + 3.0 * away}, {0.0, -0.045}, kDisc, kBarHalf);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance, 0.03, 1e-15);
  EXPECT_NEAR((hit->center - Eigen::Vector2d(0.06 + away, 0.015 + away)).norm(), 0.0, 1e-14);
}

TEST(SweepDisc, MissesWhatItOnlyPassesBy) {
  EXPECT_FALSE(sweepDisc({0.1, 0.031}, {-0.1, 0.031}, kDisc, kBarHalf)) << "1 mm above the bar";
  EXPECT_FALSE(sweepDisc({0.0, 0.05}, {0.0, 0.0301}, kDisc, kBarHalf)) << "does not get there";
  EXPECT_FALSE(sweepDisc({0.0, 0.05}, {0.0, 0.05}, kDisc, kBarHalf)) << "does not move";
}

TEST(SweepDisc, ThatOverlapsMayOnlyMoveOut) {
  EXPECT_FALSE(sweepDisc({0.0, 0.028}, {0.0, 0.05}, kDisc, kBarHalf));
  const auto hit = sweepDisc({0.0, 0.028}, {0.0, 0.027}, kDisc, kBarHalf);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->distance, 0.0);
}

TEST(SweepDisc, IsTheFirstTouchOfTheSampledPath) {
  Random random(1);
  const Box box = {kBarHalf.x(), kBarHalf.y(), 0.0, 0.0};
  const auto depth = [&](const Eigen::Vector2d& at) {
    return touchNearest(at, kDisc, box, {0.0, 0.0}, {1.0, 0.0}, 0.0).depth;
  };
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector2d start(random(-0.15, 0.15), random(-0.1, 0.1));
    const Eigen::Vector2d end(random(-0.15, 0.15), random(-0.1, 0.1));
    if (depth(start) > 0.0) {
      continue;
    }
    const auto hit = sweepDisc(start, end, kDisc, kBarHalf);
    const double met = hit ? (hit->center - start).norm() / (end - start).norm() : 1.0;
    constexpr int kSamples = 400;
    for (int k = 0; k <= kSamples; ++k) {
      const Eigen::Vector2d at = start + met * k / kSamples * (end - start);
      ASSERT_LT(depth(at), 1e-12) << "path " << i << " touches before";
    }
    if (hit) {
      ++hits;
      EXPECT_NEAR(depth(hit->center), 0.0, 1e-14);
      EXPECT_NEAR(hit->distance, (start - hit->center).dot(hit->normal), 1e-15);
      EXPECT_GE(hit->distance, 0.0);
    }
  }
  EXPECT_GT(hits, 1000);
}

/// A plastic impact: first they just meet, then they move together. The momentum stays.
TEST(Continuous, AtFiveMetersASecondThePusherMeetsTheTeeAndTakesItAlong) {
  constexpr double kSpeed = 5.0;
  constexpr double kTeeMass = kBarMass + kStemMass;
  constexpr double kTogether = dynamics::kPusherMass * kSpeed / (dynamics::kPusherMass + kTeeMass);
  for (const double gap : {0.001, 0.02, 0.049}) {
    const Model model = freeBodies(true, false);
    Bodies bodies = headOn(gap, kSpeed);
    substep(model, {0.0, 0.0}, bodies);
    const double closing = gap / kSubstep;
    EXPECT_NEAR(overlapOf(bodies), 0.0, kTight);
    EXPECT_NEAR(bodies.velocities[kTeeY] - bodies.velocities[kPusherY], closing, kTight / kSubstep);
    EXPECT_NEAR(bodies.velocities[kPusherY], -kTogether - kTeeMass / (dynamics::kPusherMass + kTeeMass) * closing,
                kTight / kSubstep);
    substep(model, {0.0, 0.0}, bodies);
    EXPECT_NEAR(bodies.velocities[kPusherY], -kTogether, 1e-4);
    EXPECT_NEAR(bodies.velocities[kTeeY], -kTogether, 1e-4);
    EXPECT_NEAR(overlapOf(bodies), 0.0, kTight);

    Bodies without = headOn(gap, kSpeed);
    substep(freeBodies(false, false), {0.0, 0.0}, without);
    EXPECT_GT(overlapOf(without), 5e-4) << "the control: it overlaps";
  }
}

/// Soft contacts let in what they need to push, and no more.
TEST(Continuous, SoftContactsOverlapByTheWidthOfTheirImpedanceAtMost) {
  for (const bool continuous : {false, true}) {
    const Model model = freeBodies(continuous, true);
    Bodies bodies = headOn(0.02, 5.0);
    double most = 0.0;
    for (int i = 0; i < 20; ++i) {
      substep(model, {0.0, 0.0}, bodies);
      most = std::max(most, overlapOf(bodies));
    }
    if (continuous) {
      EXPECT_NEAR(most, soft::kWidth, kTight);
    } else {
      EXPECT_GT(most, 0.02);
    }
  }
}

TEST(Continuous, ATeeThrownAtAWallStopsThere) {
  const Model model = freeBodies(true, true);
  Bodies bodies = {{0.0, kWallInnerFace - kTeeHalfWidth - 0.02, 0.0, 0.3, -0.3}, {0.0, 5.0, 0.0, 0.0, 0.0}};
  substep(model, {0.0, 0.0}, bodies);
  EXPECT_NEAR(bodies.velocities[kTeeY], (0.02 + soft::kWidth) / kSubstep, 1e-4);
  substep(model, {0.0, 0.0}, bodies);
  EXPECT_LE(bodies.velocities[kTeeY], 1e-4);
  EXPECT_NEAR(overlapOf(bodies), soft::kWidth, 1e-3);
  EXPECT_LE(overlapOf(bodies), soft::kWidth + kTight);
  EXPECT_NEAR(bodies.velocities[kTeeYaw], 0.0, 1e-9) << "both corners meet the wall";
}

/// Without the switch it is on the other side after a substep.
TEST(Continuous, ThePusherDoesNotPassThroughTheTee) {
  for (const bool continuous : {false, true}) {
    Bodies bodies = headOn(0.02, 12.0);
    RigidBodyParameters parameters;
    parameters.continuous = continuous;
    for (int i = 0; i < 5; ++i) {
      substep(modelOf(parameters), {0.0, -1.0}, bodies);
    }
    const double ahead = bodies.positions[kPusherY] - bodies.positions[kTeeY];
    EXPECT_EQ(ahead > 0.028, continuous) << ahead;
  }
}

TEST(Continuous, NothingStopsWhatMeetsNothing) {
  Bodies beside = {{0.0, 0.0, 0.0, 0.2, 0.031}, {0.0, 0.0, 0.0, -5.0, 0.0}};  // passes 1 mm above the bar
  Bodies before = headOn(0.06, 5.0);                                          // 10 mm are left after the substep
  for (Bodies* bodies : {&beside, &before}) {
    Bodies with = *bodies;
    const int substeps = bodies == &beside ? 8 : 1;
    for (int i = 0; i < substeps; ++i) {
      substep(modelOf({}), {0.0, 0.0}, *bodies);
      substep(modelOf(continuously({})), {0.0, 0.0}, with);
      EXPECT_EQ(bodies->positions, with.positions);
      EXPECT_EQ(bodies->velocities, with.velocities);
    }
  }
}

/// Bodies thrown at each other and at walls, with any switches.
TEST(Continuous, NoOverlapGrows) {
  constexpr double kWedged = 2e-4;  // [m] where a turning tee is wedged between pusher and wall
  Random random(2);
  int met = 0;
  int beyond = 0;
  int deep_without = 0;
  for (int i = 0; i < 2000; ++i) {
    RigidBodyParameters parameters = anySwitches(random);
    parameters.walls = parameters.shape = true;
    Bodies bodies = anyBodies(random, 5.0);
    bodies.velocities[kTeeYaw] *= 0.1;
    if (overlapOf(bodies) > 0.0) {
      continue;
    }
    Bodies without = bodies;
    substep(modelOf(parameters), {0.0, 0.0}, without);
    deep_without += overlapOf(without) > 0.005 ? 1 : 0;
    const Model model = modelOf(continuously(parameters));
    double overlap = allowedOverlap(model);
    for (int k = 0; k < 20; ++k) {
      substep(model, {random(-1.0, 1.0), random(-1.0, 1.0)}, bodies);
      ASSERT_LE(overlapOf(bodies), overlap + kWedged) << "world " << i << ", substep " << k;
      beyond += overlapOf(bodies) > overlap + kTight ? 1 : 0;
      overlap = std::max(allowedOverlap(model), overlapOf(bodies));
      met += overlap > 0.9 * allowedOverlap(model) ? 1 : 0;
    }
  }
  EXPECT_GT(met, 1000);
  EXPECT_LT(beyond, 10) << "of 40000 substeps";
  EXPECT_GT(deep_without, 100) << "the control";
}

TEST(Continuous, EnergyNeverGrowsWithoutThePushersWork) {
  Random random(3);
  int held = 0;
  for (int i = 0; i < 400; ++i) {
    RigidBodyParameters parameters = anySwitches(random);
    parameters.drag = parameters.softness = true;
    const Model model = modelOf(continuously(parameters));
    Bodies bodies = anyBodies(random, 3.0);
    bodies.velocities[kTeeYaw] *= 0.1;
    bodies.velocities[kPusherX] = bodies.velocities[kPusherY] = 0.0;
    const auto energy = [&] {
      const Matrix mass = massMatrix(model, teeOf(kCourseModel, bodies.positions));
      return 0.5 * dot(bodies.velocities, product(mass, bodies.velocities));
    };
    double most = energy();
    for (int k = 0; k < 60; ++k) {
      Bodies without = bodies;
      substep(modelOf(parameters), {0.0, 0.0}, without);
      substep(model, {0.0, 0.0}, bodies);
      held += without.velocities == bodies.velocities ? 0 : 1;
      ASSERT_LE(energy(), most * (1.0 + 1e-9)) << "world " << i << " substep " << k;
    }
  }
  EXPECT_GT(held, 100);
}

}  // namespace
}  // namespace pusht::rigid_body
