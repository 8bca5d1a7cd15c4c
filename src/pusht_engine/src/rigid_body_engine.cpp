// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/rigid_body_engine.hpp"

#include <algorithm>
#include <limits>

#include "pusht_task/error.hpp"
#include "pusht_task/mapping.hpp"

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

/// [kg m^2] Moment of inertia of the tee of a task about its origin. That of full_circle has the engine's order of
/// operations; others are told by their difference from it.
double momentInOrder(const Physics& physics) {
  constexpr double kMomentOfBoxes = kStemMass * kStemOffset * kStemOffset +
                                    momentOfPart(kBarMass, kBarHalfLength, kTeeHalfWidth) +
                                    momentOfPart(kStemMass, kTeeHalfWidth, kStemHalfLength);
  return kMomentOfBoxes + (physics.tee_second_moment - Physics().tee_second_moment);
}

void requireSwitches(const RigidBodyParameters& parameters, const Physics& physics) {
  if (physics.drive == Drive::kPosition && !parameters.servo) {
    throw InvalidInput(
        "servo false: must be true in a task whose actions are positions: the simple one holds velocities");
  }
  const Physics course;
  const bool has_course_sizes =
      physics.bar_half_length == course.bar_half_length && physics.bar_half_width == course.bar_half_width &&
      physics.stem_half_length == course.stem_half_length && physics.stem_half_width == course.stem_half_width &&
      physics.stem_offset == course.stem_offset;
  if (!parameters.shape && !has_course_sizes) {
    throw InvalidInput("shape false: must be true for this task's tee: the two discs have the sizes of the course's");
  }
}

/// Sizes of the bodies, and where they are.
void setGeometry(const Physics& physics, rigid_body::Model& model) {
  constexpr double kTeeHeight = 0.0152;         // [m] of its center, in MuJoCo's scene
  constexpr double kTeeHalfHeight = 0.015;      // [m]
  const double up = 0.0 - physics.table_point;  // which is never -0
  model.parts = {{{up,
                   {physics.bar_half_length, physics.bar_half_width, kTeeHalfHeight, kTeeHeight},
                   rigid_body::simple::kBarRadius},
                  {physics.stem_offset + up,
                   {physics.stem_half_width, physics.stem_half_length, kTeeHalfHeight, kTeeHeight},
                   rigid_body::simple::kStemRadius}}};
  const Eigen::Vector2d middle(physics.wall_middle[0], physics.wall_middle[1]);
  const double face = physics.wall_inner_face;
  model.walls = {{{1, 1.0, face, middle}, {1, -1.0, face, middle}, {0, 1.0, face, middle}, {0, -1.0, face, middle}}};
  model.pusher_radius = physics.pusher_radius;
}

}  // namespace

rigid_body::Model rigid_body::modelOf(const RigidBodyParameters& parameters, const Physics& physics) {
  constexpr double kLeastFriction = 1e-5;  // mjMINMU
  requireSwitches(parameters, physics);
  Model model = {};
  model.switches = parameters;
  model.substep = parameters.substep;
  setGeometry(physics, model);
  model.contact_friction = std::max(physics.contact_friction, kLeastFriction);
  const double moment =
      parameters.tee_inertia ? momentInOrder(physics) : physics.tee_first_moment * physics.stem_offset;
  const TeeInertia tee = {physics.tee_mass, physics.tee_first_moment, moment};
  model.tee_mass = tee.mass;
  model.tee_moment = tee.momentAbout(physics.table_point);
  model.center_of_mass = physics.centerOfMass() - physics.table_point;
  model.pusher_mass = parameters.pusher_inertia ? physics.pusher_mass : simple::kPusherMass;

  // The servo moves a free pusher in the same way, whatever its mass in contact is.
  if (parameters.servo) {
    const double scale = model.pusher_mass / physics.pusher_mass;
    const bool is_to_position = physics.drive == Drive::kPosition;
    model.servo_stiffness = is_to_position ? scale * physics.servo_stiffness : 0.0;
    model.servo_gain = scale * physics.servo_gain;
    model.servo_limit = scale * physics.servo_limit;
    model.pusher_damping = scale * physics.pusher_damping;
    model.servo_derivative = model.servo_gain + model.pusher_damping;
  } else {
    model.servo_gain = model.pusher_mass * simple::kServoRate;
    model.servo_limit = std::numeric_limits<double>::infinity();
  }
  if (parameters.drag) {
    model.tee_damping = physics.tee_damping;
    model.tee_yaw_damping = physics.tee_yaw_damping;
  } else {
    model.drag_rate = simple::kDragRate;
  }

  // What MuJoCo calls invweight0: the inverse inertia at yaw 0, of coordinates and, as a mean over the three directions
  // of space, of bodies.
  const double center = model.center_of_mass;
  const double central_moment = model.tee_moment - tee.mass * center * center;
  const double by_turning = center * center / central_moment;
  const std::array<double, 3> inverse = {1.0 / tee.mass + by_turning, 1.0 / tee.mass, 1.0 / central_moment};
  model.coulomb_limit = {physics.tee_friction[0], physics.tee_friction[1], physics.tee_yaw_friction};
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    model.coulomb_regularity[i] = soft::kLeastImpedance / (1.0 - soft::kLeastImpedance) / inverse[i];
  }
  model.tee_wall_weight = 2.0 / 3.0 / tee.mass;
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
