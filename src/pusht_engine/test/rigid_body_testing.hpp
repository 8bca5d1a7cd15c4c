// SPDX-License-Identifier: BSD-3-Clause
/// Helpers of the rigid-body engine's tests.
#pragma once

#include <random>

#include "pusht_engine/rigid_body_engine.hpp"
#include "rigid_body_dynamics.hpp"

namespace pusht::rigid_body {

constexpr std::array<double, kCoordinateCount> kStill = {};
inline const Model kCourseModel = modelOf({});  ///< of full_circle, with all switches on

class Random {
 public:
  explicit Random(std::uint64_t seed) : generator_(seed) {}

  double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(generator_); }
  bool flip() { return (generator_() & 1U) != 0; }

 private:
  std::mt19937_64 generator_;
};

inline RigidBodyParameters allSimple() {
  RigidBodyParameters parameters;
  for (const Switch& each : kSwitches) {
    parameters.*each.value = false;
  }
  return parameters;
}

inline RigidBodyParameters without(bool RigidBodyParameters::*which) {
  RigidBodyParameters parameters;
  parameters.*which = false;
  return parameters;
}

inline RigidBodyParameters anySwitches(Random& random) {
  RigidBodyParameters parameters;
  for (const Switch& each : kSwitches) {
    parameters.*each.value = random.flip();
  }
  return parameters;
}

/// Somewhere on the table, away from the walls, with the pusher so near that it touches in many cases.
inline Bodies anyBodies(Random& random, double speed) {
  Bodies bodies;
  bodies.positions[kTeeX] = random(-0.1, 0.1);
  bodies.positions[kTeeY] = random(-0.1, 0.1);
  bodies.positions[kTeeYaw] = random(-kPi, kPi);
  const double way = random(-kPi, kPi);
  const double distance = random(0.02, 0.12);
  bodies.positions[kPusherX] = bodies.positions[kTeeX] + distance * std::cos(way);
  bodies.positions[kPusherY] = bodies.positions[kTeeY] + distance * std::sin(way);
  for (std::size_t i = 0; i < kCoordinateCount; ++i) {
    bodies.velocities[i] = random(-speed, speed);
  }
  bodies.velocities[kTeeYaw] *= 10.0;
  return bodies;
}

/// Quantities of a substep, one by one.
struct Parts {
  Model model;
  Bodies bodies;
  Tee tee = teeOf(model, bodies.positions);
  Eigen::Vector2d pusher = {bodies.positions[kPusherX], bodies.positions[kPusherY]};
  Matrix mass = massMatrix(model, tee);

  Parts(const RigidBodyParameters& parameters, const Bodies& world) : model(modelOf(parameters)), bodies(world) {}

  Vector smooth(const Eigen::Vector2d& command = {0.0, 0.0}) const {
    return smoothForce(model, tee, mass, bodies, command);
  }
  Contact touch(const Part& part) const { return touchTee(model, tee, pusher, part); }
  Rows rows() const { return constraintsOf(model, tee, findContacts(model, tee, pusher), bodies.velocities); }
};

}  // namespace pusht::rigid_body
