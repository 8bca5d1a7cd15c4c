// SPDX-License-Identifier: BSD-3-Clause
// The laws of the rigid-body engine: closed forms, symmetries, energy, and finite differences of every derivative.
// (Against MuJoCo: sim2sim_eval's fidelity_test.cpp.)
#include "rigid_body_dynamics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_task/contact.hpp"
#include "rigid_body_testing.hpp"

namespace pusht::rigid_body {
namespace {

constexpr double kStep = 1e-6;  // of finite differences

/// MuJoCo's dof_invweight0 and body_invweight0 of this scene, and the tee's inertia, by hand.
TEST(Model, HasTheNumbersOfMuJoCosScene) {
  const Model model = modelOf({});
  const std::array<double, 3> inverse = {12.783929, 9.523810, 4930.445};
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    EXPECT_NEAR(9.0 / model.coulomb_regularity[i], inverse[i], 1e-6 * inverse[i]);
  }
  EXPECT_NEAR(model.tee_wall_weight, 6.349206, 1e-6);
  EXPECT_NEAR(model.pusher_wall_weight, 3.333333, 1e-6);
}

TEST(Model, AFreePusherMovesTheSameWhateverItsInertiaInContact) {
  Bodies light = {{0.3, 0.3, 0.0, -0.1, -0.1}, {0.0, 0.0, 0.0, 0.2, -0.4}};
  Bodies heavy = light;
  for (int i = 0; i < 20; ++i) {
    substep(modelOf({}), {1.0, -0.5}, light);
    substep(modelOf(without(&RigidBodyParameters::pusher_inertia)), {1.0, -0.5}, heavy);
    EXPECT_NEAR(light.velocities[kPusherX], heavy.velocities[kPusherX], 1e-14);
    EXPECT_NEAR(light.velocities[kPusherY], heavy.velocities[kPusherY], 1e-14);
  }
}

TEST(Substep, TheServoSettlesWhereForceAndDampingAreEven) {
  Bodies bodies = {{0.3, 0.3, 0.0, -0.2, 0.0}, kStill};
  for (int i = 0; i < 40; ++i) {
    substep(modelOf({}), {0.5, 0.0}, bodies);
  }
  EXPECT_NEAR(bodies.velocities[kPusherX], 0.5 * 20.0 / 20.5, 1e-12);
}

/// Along the line through its center of mass it does not turn: (m + 0.01 d) dv = -0.01 (d v + f), and then it rests.
TEST(Substep, ASlidingTeeDeceleratesAsTheClosedFormSays) {
  Bodies bodies = {{0.0, -0.1, 0.0, 0.3, 0.3}, {0.0, 2.0, 0.0, 0.0, 0.0}};
  const Model model = modelOf({});
  double expected = 2.0;
  int sliding = 0;
  for (int i = 0; i < 100; ++i) {
    substep(model, {0.0, 0.0}, bodies);
    expected += kSubstep * -(4.0 * expected + 1.2) / (0.105 + kSubstep * 4.0);
    // The friction is at its limit where more than that is missing.
    if (expected > 0.05) {
      EXPECT_NEAR(bodies.velocities[kTeeY], expected, 1e-13);
      ++sliding;
    }
    EXPECT_EQ(bodies.velocities[kTeeX], 0.0);
    EXPECT_EQ(bodies.velocities[kTeeYaw], 0.0);
  }
  EXPECT_GE(sliding, 5);
  EXPECT_NEAR(bodies.velocities[kTeeY], 0.0, 1e-6) << "at rest";
}

TEST(Substep, WithoutDragAndFrictionTheCenterOfMassKeepsItsVelocity) {
  RigidBodyParameters free = allSimple();
  Model model = modelOf(free);
  model.drag_rate = 0.0;
  Bodies bodies = {{0.0, 0.0, 0.4, 0.3, 0.3}, {0.1, -0.2, 3.0, 0.0, 0.0}};
  const auto center = [](const Bodies& b) {
    const Tee tee = teeOf(kCourseModel, b.positions);
    return Eigen::Vector2d(tee.origin + tee.center_of_mass);
  };
  const Eigen::Vector2d start = center(bodies);
  const Tee tee = teeOf(kCourseModel, bodies.positions);
  const Eigen::Vector2d velocity(0.1 - 3.0 * tee.center_of_mass.y(), -0.2 + 3.0 * tee.center_of_mass.x());
  for (int i = 0; i < 10; ++i) {
    substep(model, {0.0, 0.0}, bodies);
  }
  // The integrator is of first order: half a turn a second, a center 26 mm off, substeps of 10 ms.
  EXPECT_LT((center(bodies) - start - 0.1 * velocity).norm(), 2e-4);
  EXPECT_NEAR(bodies.velocities[kTeeYaw], 3.0, 1e-3);
}

/// The tee slides, turns, hits walls and a pusher that holds still. A soft contact gives back no more than it took.
/// (A hard one does: it removes a fifth of an overlap in a substep, however that came. And without drag the explicit
/// centrifugal force alone makes a spinning tee a little faster: the integrator is of first order.)
TEST(Substep, EnergyNeverGrowsWithoutThePushersWork) {
  Random random(1);
  int at_pusher = 0;
  int at_wall = 0;
  for (int i = 0; i < 400; ++i) {
    RigidBodyParameters parameters = anySwitches(random);
    parameters.drag = true;
    parameters.softness = true;
    const Model model = modelOf(parameters);
    Bodies bodies = {{random(-0.25, 0.25), random(-0.25, 0.25), random(-kPi, kPi), 0.0, 0.0}, kStill};
    bodies.velocities = {random(-6.0, 6.0), random(-6.0, 6.0), random(-30.0, 30.0), 0.0, 0.0};
    const double way = std::atan2(bodies.velocities[kTeeY], bodies.velocities[kTeeX]);
    bodies.positions[kPusherX] = bodies.positions[kTeeX] + 0.125 * std::cos(way);
    bodies.positions[kPusherY] = bodies.positions[kTeeY] + 0.125 * std::sin(way);
    const auto energy = [&] {
      const Matrix mass = massMatrix(model, teeOf(kCourseModel, bodies.positions));
      return 0.5 * dot(bodies.velocities, product(mass, bodies.velocities));
    };
    double most = energy();
    for (int k = 0; k < 60; ++k) {
      const Parts parts(parameters, bodies);
      at_pusher += parts.touch(kCourseModel.parts[0]).touching || parts.touch(kCourseModel.parts[1]).touching ? 1 : 0;
      at_wall += parameters.walls && wallGapsOf(RigidBodyPhysics::stateOf(bodies)).tee < 0.0 ? 1 : 0;
      substep(model, {0.0, 0.0}, bodies);
      ASSERT_LE(energy(), most * (1.0 + 1e-9)) << "world " << i << " substep " << k;
    }
  }
  EXPECT_GT(at_pusher, 500);
  EXPECT_GT(at_wall, 300);
}

TEST(Constraints, ForcesStayInTheConeAndInTheBox) {
  Random random(2);
  int sticking = 0;
  int slipping = 0;
  for (int i = 0; i < 4000; ++i) {
    RigidBodyParameters parameters = anySwitches(random);
    parameters.friction = true;
    const Parts parts(parameters, anyBodies(random, 0.6));
    const auto bar = parts.touch(kCourseModel.parts[0]);
    const auto stem = parts.touch(kCourseModel.parts[1]);
    const Vector force = constraintForce(parts.mass, parts.smooth(), parts.rows());
    // On the pusher there are contact forces alone, with the tee's Coulomb friction there is more on the tee.
    if (bar.touching != stem.touching) {
      const Eigen::Vector2d& normal = bar.touching ? bar.normal : stem.normal;
      const Eigen::Vector2d on_tee = {-force[kPusherX], -force[kPusherY]};
      const double along = on_tee.dot(normal);
      const double across = std::abs(on_tee.x() * normal.y() - on_tee.y() * normal.x());
      EXPECT_GE(along, 0.0);
      EXPECT_LE(across, along * (1.0 + 1e-9) + 1e-12);
      (across < 0.999 * along ? sticking : slipping) += along > 1e-6 ? 1 : 0;
    } else if (!bar.touching) {
      const std::array<double, 3> limits = {1.2, 1.2, 0.006};
      for (std::size_t j = 0; j < limits.size(); ++j) {
        EXPECT_LE(std::abs(force[j]), parameters.coulomb ? limits[j] * (1.0 + 1e-12) : 0.0);
      }
    }
  }
  EXPECT_GT(sticking, 100);
  EXPECT_GT(slipping, 100);
}

void expectSame(double found, double expected) { EXPECT_NEAR(found, expected, 1e-8 * (1.0 + std::abs(expected))); }

/// x is mirrored, in space and in every switch.
TEST(Substep, MirrorsMirroredWorlds) {
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    RigidBodyParameters parameters = anySwitches(random);
    parameters.narrow_phase = false;  // libccd's portals are of one hand
    const Model model = modelOf(parameters);
    Bodies bodies = anyBodies(random, 0.5);
    Bodies mirrored = bodies;
    for (const Coordinate odd : {kTeeX, kTeeYaw, kPusherX}) {
      mirrored.positions[odd] = -bodies.positions[odd];
      mirrored.velocities[odd] = -bodies.velocities[odd];
    }
    substep(model, {0.3, 0.2}, bodies);
    substep(model, {-0.3, 0.2}, mirrored);
    for (const Coordinate odd : {kTeeX, kTeeYaw, kPusherX}) {
      expectSame(mirrored.velocities[odd], -bodies.velocities[odd]);
    }
    expectSame(mirrored.velocities[kTeeY], bodies.velocities[kTeeY]);
    expectSame(mirrored.velocities[kPusherY], bodies.velocities[kPusherY]);
  }
}

Vector turned(const Vector& v) { return {-v[kTeeY], v[kTeeX], v[kTeeYaw], -v[kPusherY], v[kPusherX]}; }

/// By a quarter; by half if there is Coulomb friction, whose compliance MuJoCo takes at yaw 0, where x is not y.
TEST(Substep, TurnsTurnedWorlds) {
  Random random(4);
  for (int i = 0; i < 500; ++i) {
    RigidBodyParameters parameters = anySwitches(random);
    parameters.narrow_phase = false;
    const Model model = modelOf(parameters);
    Bodies bodies = anyBodies(random, 0.5);
    Bodies other = bodies;
    Eigen::Vector2d command = {0.3, 0.2};
    const int quarters = parameters.coulomb ? 2 : 1;
    for (int quarter = 0; quarter < quarters; ++quarter) {
      other = {turned(other.positions), turned(other.velocities)};
      other.positions[kTeeYaw] += 0.5 * kPi;
      command = {-command.y(), command.x()};
    }
    substep(model, {0.3, 0.2}, bodies);
    substep(model, command, other);
    Vector expected = bodies.velocities;
    for (int quarter = 0; quarter < quarters; ++quarter) {
      expected = turned(expected);
    }
    for (std::size_t j = 0; j < kCoordinateCount; ++j) {
      expectSame(other.velocities[j], expected[j]);
    }
  }
}

/// The acceleration solves (M - h D) a = f, with D by finite differences of the smooth force.
TEST(ImplicitAcceleration, HasTheDerivativeOfTheSmoothForce) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    RigidBodyParameters parameters;
    parameters.tee_inertia = random.flip();
    parameters.pusher_inertia = random.flip();
    const Parts parts(parameters, anyBodies(random, 0.4));
    const Vector force = {random(-1.0, 1.0), random(-1.0, 1.0), random(-0.1, 0.1), random(-5.0, 5.0),
                          random(-5.0, 5.0)};
    const Vector found = implicitAcceleration(parts.model, parts.tee, parts.mass, parts.bodies.velocities, force);
    Vector left = product(parts.mass, found);
    for (std::size_t j = 0; j < kCoordinateCount; ++j) {
      const auto smooth_at = [&](double change) {
        Vector velocities = parts.bodies.velocities;
        velocities[j] += change;
        return smoothForce(parts.model, parts.tee, parts.mass, {parts.bodies.positions, velocities}, {0.0, 0.0});
      };
      const Vector above = smooth_at(kStep);
      const Vector below = smooth_at(-kStep);
      for (std::size_t k = 0; k < kCoordinateCount; ++k) {
        left[k] -= kSubstep * (above[k] - below[k]) / (2.0 * kStep) * found[j];
      }
    }
    for (std::size_t k = 0; k < kCoordinateCount; ++k) {
      EXPECT_NEAR(left[k], force[k], 1e-7) << "world " << i << " coordinate " << k;
    }
  }
}

/// A contact's depth shrinks as fast as its jacobian along the normal says.
TEST(JacobianAlong, IsTheDerivativeOfTheDepth) {
  Random random(6);
  int touching = 0;
  for (int i = 0; i < 3000; ++i) {
    RigidBodyParameters parameters = without(&RigidBodyParameters::narrow_phase);
    parameters.shape = random.flip();
    Bodies bodies = anyBodies(random, 0.5);
    const Parts parts(parameters, bodies);
    const Part& part = kCourseModel.parts[random.flip() ? 1 : 0];
    const auto contact = parts.touch(part);
    if (!contact.touching || contact.depth > 0.01) {
      continue;
    }
    ++touching;
    const Vector jacobian = jacobianAlong(contact.normal, contact.point - parts.tee.origin, Pair::kTeePusher);
    const auto depth_after = [&](double time) {
      Bodies moved = bodies;
      for (std::size_t j = 0; j < kCoordinateCount; ++j) {
        moved.positions[j] += time * bodies.velocities[j];
      }
      const Parts later(parameters, moved);
      return later.touch(part).depth;
    };
    const double rate = (depth_after(kStep) - depth_after(-kStep)) / (2.0 * kStep);
    EXPECT_NEAR(rate, -dot(jacobian, bodies.velocities), 1e-6) << "world " << i;
  }
  EXPECT_GT(touching, 200);
}

/// The tee's origin, center of mass and axes turn as the yaw does.
TEST(TeeOf, HasTheDerivativeOfItsYaw) {
  for (const double yaw : {-3.0, -0.7, 0.0, 0.4, 2.5}) {
    const auto at = [](double angle) { return teeOf(kCourseModel, {0.1, 0.2, angle, 0.0, 0.0}); };
    const Eigen::Vector2d rate = (at(yaw + kStep).center_of_mass - at(yaw - kStep).center_of_mass) / (2.0 * kStep);
    const Eigen::Vector2d center = at(yaw).center_of_mass;
    EXPECT_NEAR(rate.x(), -center.y(), 1e-9);
    EXPECT_NEAR(rate.y(), center.x(), 1e-9);
    EXPECT_NEAR(at(yaw).heading.cosine, std::cos(yaw), 1e-15);
    EXPECT_NEAR(at(yaw).heading.sine, std::sin(yaw), 1e-15);
  }
}

/// With all switches off it is the two-mass engine but for the link between the masses. There it gives way, and passes
/// a push on only in the next substep. So a free tee is the same up to the link's small swing, and a pushed one is not.
TEST(AllSimple, IsTheTwoMassEngineButForItsSoftLink) {
  const auto distance_after_step = [](const Bodies& bodies, const Eigen::Vector2d& command) {
    RigidBodyEngine rigid(allSimple());
    TwoMassEngine soft;
    rigid.reset(RigidBodyPhysics::stateOf(bodies));
    soft.reset(RigidBodyPhysics::stateOf(bodies));
    const Action action = {static_cast<float>(command.x()), static_cast<float>(command.y())};
    rigid.step(action);
    soft.step(action);
    return std::array<double, 2>{(rigid.state().tee_position - soft.state().tee_position).norm(),
                                 (rigid.state().pusher_position - soft.state().pusher_position).norm()};
  };
  Random random(7);
  std::vector<double> pushed;
  double free = 0.0;
  for (int i = 0; i < 2000; ++i) {
    Bodies bodies = anyBodies(random, 0.0);
    const Tee tee = teeOf(kCourseModel, bodies.positions);
    const Part& part = kCourseModel.parts[i % 2];
    const Eigen::Vector2d center = centerOf(part, tee);
    const double way = random(-kPi, kPi);
    const Eigen::Vector2d out(std::cos(way), std::sin(way));
    const Eigen::Vector2d pusher = center + (part.disc_radius + kPusherRadius + 0.0005) * out;
    bodies.positions[kPusherX] = pusher.x();
    bodies.positions[kPusherY] = pusher.y();
    const Part& other = kCourseModel.parts[1 - i % 2];
    if (!touchDiscs(centerOf(other, tee), other.disc_radius, pusher, kPusherRadius, 0.0).touching) {
      pushed.push_back(distance_after_step(bodies, -0.2 * out)[0]);
    }

    bodies.positions[kPusherX] = 0.35;
    bodies.velocities = {random(-0.2, 0.2), random(-0.2, 0.2), random(-2.0, 2.0), 0.0, 0.0};
    const auto [of_tee, of_pusher] = distance_after_step(bodies, out);
    free = std::max(free, of_tee);
    EXPECT_LT(of_pusher, 1e-15) << "the same servo";
  }
  std::sort(pushed.begin(), pushed.end());
  EXPECT_LT(free, 3e-5);
  ASSERT_GT(pushed.size(), 1000U);
  EXPECT_LT(pushed[pushed.size() / 2], 5e-4);
  EXPECT_LT(pushed.back(), 5e-3) << "of 20 mm that the pusher moves";
}

}  // namespace
}  // namespace pusht::rigid_body
