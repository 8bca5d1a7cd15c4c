// SPDX-License-Identifier: BSD-3-Clause
#include "rigid_body_dynamics.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "continuous_contact.hpp"
#include "pusht_task/constants.hpp"

namespace pusht::rigid_body {
namespace {

/// Adds Coulomb friction with the table on each coordinate of the tee: a force against the motion, up to a limit.
void addTableFriction(const Model& model, const Vector& velocities, Rows& rows) {
  for (std::size_t i = 0; i < model.coulomb_limit.size(); ++i) {
    Vector jacobian = {};
    jacobian[i] = 1.0;
    rows.add({jacobian, -soft::kDamping * velocities[i], model.coulomb_regularity[i], -model.coulomb_limit[i],
              model.coulomb_limit[i]});
  }
}

/// [1/kg] Scale of the compliance of contacts between a pair.
double weightOf(const Model& model, Pair pair) {
  switch (pair) {
    case Pair::kTeePusher:
      return model.tee_pusher_weight;
    case Pair::kTeeWall:
      return model.tee_wall_weight;
    default:
      return model.pusher_wall_weight;
  }
}

/// Adds the rows of a contact. With friction they are MuJoCo's pyramid of four edges: in the plane two slant to either
/// side, and two, which slant up and down, are both the normal.
void addContact(const Model& model, const Tee& tee, const Contact& contact, const Vector& velocities, Rows& rows) {
  const bool soft = model.switches.softness;
  const double hardness = soft ? impedance(contact.depth) : 1.0 - simple::kCompliance;
  const double spring = soft ? soft::kStiffness * hardness * contact.depth
                             : simple::kOverlapShare / (model.substep * model.substep) * contact.depth;
  const double damping = soft ? soft::kDamping : 1.0 / model.substep;
  const double stiffness = contact.multiplicity / weightOf(model, contact.pair) * hardness / (1.0 - hardness);
  const Eigen::Vector2d arm = contact.point - tee.origin;

  const auto add = [&](const Eigen::Vector2d& direction, double of_edge) {
    const Vector jacobian = jacobianAlong(direction, arm, contact.pair);
    const double wanted = spring - damping * dot(jacobian, velocities);
    rows.add({jacobian, wanted, of_edge, 0.0, std::numeric_limits<double>::infinity()});
  };
  if (!model.switches.friction) {
    add(contact.normal, stiffness);
    return;
  }
  const double mu = model.contact_friction;
  const double of_edge = stiffness / (2.0 * mu * mu * (1.0 + mu * mu));
  const Eigen::Vector2d slanted(-mu * contact.normal.y(), mu * contact.normal.x());
  add(contact.normal + slanted, of_edge);
  add(contact.normal - slanted, of_edge);
  add(contact.normal, 2.0 * of_edge);
}

}  // namespace

void substep(const Model& model, const Eigen::Vector2d& command, Bodies& bodies) {
  auto& [positions, velocities] = bodies;
  const Tee tee = teeOf(model, positions);
  const Eigen::Vector2d pusher(positions[kPusherX], positions[kPusherY]);

  // Forces on free bodies.
  const Matrix mass = massMatrix(model, tee);
  Vector force = smoothForce(model, tee, mass, bodies, command);

  // Forces of constraints: friction with the table, contacts.
  const Contacts contacts = findContacts(model, tee, pusher);
  const Rows rows = constraintsOf(model, tee, contacts, velocities);
  const Vector constraint = constraintForce(mass, force, rows);
  for (std::size_t i = 0; i < kCoordinateCount; ++i) {
    force[i] += constraint[i];
  }

  // Velocities by the implicit integrator, positions by the new velocities.
  Vector acceleration = implicitAcceleration(model, tee, mass, velocities, force);
  if (model.switches.continuous) {
    acceleration = withoutOverlap(model, mass, bodies, acceleration);
  }
  for (std::size_t i = 0; i < kCoordinateCount; ++i) {
    velocities[i] += model.substep * acceleration[i];
    positions[i] += model.substep * velocities[i];
  }
}

Tee teeOf(const Model& model, const Vector& positions) {
  const Heading heading = headingOf(positions[kTeeYaw]);
  return {{positions[kTeeX], positions[kTeeY]},
          heading,
          {model.center_of_mass * heading.sine, -model.center_of_mass * heading.cosine}};
}

Matrix massMatrix(const Model& model, const Tee& tee) {
  const Eigen::Vector2d moment = model.tee_mass * tee.center_of_mass;  // [kg m] the first moment
  return {Vector{model.tee_mass, 0.0, -moment.y(), 0.0, 0.0}, Vector{0.0, model.tee_mass, moment.x(), 0.0, 0.0},
          Vector{-moment.y(), moment.x(), model.tee_moment, 0.0, 0.0}, Vector{0.0, 0.0, 0.0, model.pusher_mass, 0.0},
          Vector{0.0, 0.0, 0.0, 0.0, model.pusher_mass}};
}

Vector smoothForce(const Model& model, const Tee& tee, const Matrix& mass, const Bodies& bodies,
                   const Eigen::Vector2d& command) {
  const auto& [positions, velocities] = bodies;
  const Vector momentum = product(mass, velocities);
  const double spin = velocities[kTeeYaw];
  const Eigen::Vector2d centrifugal = (model.tee_mass * spin * spin) * tee.center_of_mass;
  const auto servo = [&](double wanted, double position, double velocity) {
    const double pull = model.servo_stiffness > 0.0
                            ? model.servo_stiffness * (wanted - position) - model.servo_gain * velocity
                            : model.servo_gain * (wanted - velocity);
    return std::clamp(pull, -model.servo_limit, model.servo_limit) - model.pusher_damping * velocity;
  };
  Vector force;
  force[kTeeX] = centrifugal.x() - model.tee_damping * velocities[kTeeX] - model.drag_rate * momentum[kTeeX];
  force[kTeeY] = centrifugal.y() - model.tee_damping * velocities[kTeeY] - model.drag_rate * momentum[kTeeY];
  force[kTeeYaw] = -model.tee_yaw_damping * spin - model.drag_rate * momentum[kTeeYaw];
  force[kPusherX] = servo(command.x(), positions[kPusherX], velocities[kPusherX]);
  force[kPusherY] = servo(command.y(), positions[kPusherY], velocities[kPusherY]);
  return force;
}

Rows constraintsOf(const Model& model, const Tee& tee, const Contacts& contacts, const Vector& velocities) {
  Rows rows;
  if (model.switches.coulomb) {
    addTableFriction(model, velocities, rows);
  }
  for (const Contact& contact : contacts) {
    addContact(model, tee, contact, velocities, rows);
  }
  return rows;
}

double impedance(double depth) {
  const double x = depth < soft::kWidth ? depth / soft::kWidth : 1.0;
  const double rise = x < 0.5 ? 2.0 * x * x : 1.0 - 2.0 * (1.0 - x) * (1.0 - x);
  return soft::kLeastImpedance + rise * (soft::kImpedance - soft::kLeastImpedance);
}

Vector jacobianAlong(const Eigen::Vector2d& direction, const Eigen::Vector2d& arm, Pair pair) {
  const double turn = arm.x() * direction.y() - arm.y() * direction.x();
  switch (pair) {
    case Pair::kTeePusher:
      return {direction.x(), direction.y(), turn, -direction.x(), -direction.y()};
    case Pair::kTeeWall:
      return {direction.x(), direction.y(), turn, 0.0, 0.0};
    default:
      return {0.0, 0.0, 0.0, direction.x(), direction.y()};
  }
}

Vector implicitAcceleration(const Model& model, const Tee& tee, const Matrix& mass, const Vector& velocities,
                            const Vector& force) {
  // The tee's rows are (d, 0, p), (0, d, q), (r, s, t); the first two are put into the third.
  const Eigen::Vector2d centrifugal = (2.0 * model.tee_mass * velocities[kTeeYaw]) * tee.center_of_mass;
  const double d = model.tee_mass + model.substep * model.tee_damping;
  const double p = mass[kTeeX][kTeeYaw] - model.substep * centrifugal.x();
  const double q = mass[kTeeY][kTeeYaw] - model.substep * centrifugal.y();
  const double r = mass[kTeeYaw][kTeeX] / d;
  const double s = mass[kTeeYaw][kTeeY] / d;
  const double t = mass[kTeeYaw][kTeeYaw] + model.substep * model.tee_yaw_damping;
  Vector acceleration;
  acceleration[kTeeYaw] = (force[kTeeYaw] - r * force[kTeeX] - s * force[kTeeY]) / (t - r * p - s * q);
  acceleration[kTeeX] = (force[kTeeX] - p * acceleration[kTeeYaw]) / d;
  acceleration[kTeeY] = (force[kTeeY] - q * acceleration[kTeeYaw]) / d;
  const double pusher = model.pusher_mass + model.substep * model.servo_derivative;
  acceleration[kPusherX] = force[kPusherX] / pusher;
  acceleration[kPusherY] = force[kPusherY] / pusher;
  return acceleration;
}

}  // namespace pusht::rigid_body
