// SPDX-License-Identifier: BSD-3-Clause
/// What the tests of the rigid-body engine share.
#pragma once

#include <random>

#include "pusht_engine/rigid_body_dynamics.hpp"
#include "pusht_engine/rigid_body_engine.hpp"

namespace pusht::rigid_body {

constexpr std::array<double, kCoordinateCount> kStill = {};

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
inline Bodies<double> anyBodies(Random& random, double speed) {
  Bodies<double> bodies;
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

/// What a substep makes of a world, for whoever looks at its parts.
struct Parts {
  Model model;
  Bodies<double> bodies;
  Tee<double> tee = teeOf(bodies.positions);
  Scene<double> scene = {{bodies.positions[kPusherX], bodies.positions[kPusherY]},
                         model,
                         tee,
                         model.switches.softness ? 0.0 : simple::kMargin};
  Matrix<double> mass = massMatrix(model, tee);

  Parts(const RigidBodyParameters& parameters, const Bodies<double>& world)
      : model(modelOf(parameters)), bodies(world) {}
  Parts(const Parts&) = delete;
  Parts& operator=(const Parts&) = delete;
  ~Parts() = default;

  Vector<double> smooth(const Vector2<double>& command = {0.0, 0.0}) const {
    return smoothForce(model, tee, mass, bodies.velocities, command);
  }
  Rows<double> rows() const { return constraintsOf(scene, bodies.velocities); }
};

}  // namespace pusht::rigid_body
