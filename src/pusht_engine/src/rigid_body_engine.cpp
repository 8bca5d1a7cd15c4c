// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/rigid_body_engine.hpp"

namespace pusht {
namespace {

using rigid_body::kPusherX;
using rigid_body::kPusherY;
using rigid_body::kTeeX;
using rigid_body::kTeeY;
using rigid_body::kTeeYaw;

/// [kg m^2] Moment of inertia of a box about its center, in the plane. Its order of operations decides the engine's
/// bits.
constexpr double momentOfPart(double mass, double half_x, double half_y) {
  return mass / 3.0 * (half_x * half_x + half_y * half_y);
}

}  // namespace

rigid_body::Model rigid_body::modelOf(const RigidBodyParameters& parameters) {
  using namespace dynamics;
  constexpr double kTeeMass = kBarMass + kStemMass;
  constexpr double kMomentOfPoints = kStemMass * kStemOffset * kStemOffset;
  constexpr double kMomentOfBoxes = kMomentOfPoints + momentOfPart(kBarMass, kBarHalfLength, kTeeHalfWidth) +
                                    momentOfPart(kStemMass, kTeeHalfWidth, kStemHalfLength);
  Model model = {};
  model.switches = parameters;
  model.substep = parameters.substep;
  model.tee_mass = kTeeMass;
  model.tee_moment = parameters.tee_inertia ? kMomentOfBoxes : kMomentOfPoints;
  model.pusher_mass = parameters.pusher_inertia ? kPusherMass : simple::kPusherMass;

  // The servo moves a free pusher in the same way, whatever its mass in contact is.
  if (parameters.servo) {
    const double scale = model.pusher_mass / kPusherMass;
    model.servo_gain = scale * kServoGain;
    model.servo_limit = scale * kServoLimit;
    model.pusher_damping = scale * kPusherDamping;
    model.servo_derivative = model.servo_gain + model.pusher_damping;
  } else {
    model.servo_gain = model.pusher_mass * simple::kServoRate;
    model.servo_limit = std::numeric_limits<double>::infinity();
  }
  if (parameters.drag) {
    model.tee_damping = kTeeDamping;
    model.tee_yaw_damping = kTeeYawDamping;
  } else {
    model.drag_rate = simple::kDragRate;
  }

  // What MuJoCo calls invweight0: the inverse inertia at yaw 0, of coordinates and, as a mean over the three directions
  // of space, of bodies.
  const double central_moment = model.tee_moment - kTeeMass * kCenterOfMassOffset * kCenterOfMassOffset;
  const double by_turning = kCenterOfMassOffset * kCenterOfMassOffset / central_moment;
  const std::array<double, 3> inverse = {1.0 / kTeeMass + by_turning, 1.0 / kTeeMass, 1.0 / central_moment};
  model.coulomb_limit = {kTeeFriction, kTeeFriction, kTeeYawFriction};
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    model.coulomb_regularity[i] = soft::kLeastImpedance / (1.0 - soft::kLeastImpedance) / inverse[i];
  }
  model.tee_wall_weight = 2.0 / 3.0 / kTeeMass;
  model.pusher_wall_weight = 2.0 / 3.0 / model.pusher_mass;
  model.tee_pusher_weight = model.tee_wall_weight + model.pusher_wall_weight;
  return model;
}

RigidBodyPhysics::Bodies RigidBodyPhysics::bodiesOf(const WorldState& state) {
  return {{state.tee_position.x(), state.tee_position.y(), state.tee_yaw, state.pusher_position.x(),
           state.pusher_position.y()},
          {state.tee_velocity.x(), state.tee_velocity.y(), state.tee_yaw_rate, state.pusher_velocity.x(),
           state.pusher_velocity.y()}};
}

WorldState RigidBodyPhysics::stateOf(const Bodies& bodies) {
  const auto& [positions, velocities] = bodies;
  WorldState state;
  state.tee_position = {positions[kTeeX], positions[kTeeY]};
  state.tee_velocity = {velocities[kTeeX], velocities[kTeeY]};
  state.tee_yaw = wrapAngle(positions[kTeeYaw]);
  state.tee_yaw_rate = velocities[kTeeYaw];
  state.pusher_position = {positions[kPusherX], positions[kPusherY]};
  state.pusher_velocity = {velocities[kPusherX], velocities[kPusherY]};
  return state;
}

template class PlanarSimulator<RigidBodyPhysics>;

}  // namespace pusht
