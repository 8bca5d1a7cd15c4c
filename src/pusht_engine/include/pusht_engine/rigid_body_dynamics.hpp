// SPDX-License-Identifier: BSD-3-Clause
/// The physics of the rigid-body engine, for one world or many: MuJoCo's of this scene, each part of which a switch
/// replaces by the two-mass engine's. Units are SI, vectors in table axes.
/// Source of the faithful parts: the chapter "Computation" of MuJoCo's documentation, for the integrator `implicit`.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "pusht_engine/rigid_body_contacts.hpp"
#include "pusht_engine/rigid_body_model.hpp"
#include "pusht_engine/rigid_body_solver.hpp"
#include "pusht_engine/simd.hpp"
#include "pusht_task/constants.hpp"

namespace pusht::rigid_body {

/// Every number of a world that changes. The yaw is not wrapped.
template <class Real>
struct Bodies {
  Vector<Real> positions;   ///< [m, m, rad, m, m]
  Vector<Real> velocities;  ///< per second
};

/// The tee's pose as geometry.
template <class Real>
struct Tee {
  Vector2<Real> origin;
  Heading<Real> heading;
  Vector2<Real> centre_of_mass;  ///< [m] from the origin
};

/// By half angles, as MuJoCo turns bodies by quaternions: portals are found by comparisons, which last bits decide.
inline Heading<double> headingOf(double yaw) {
  const double cosine = std::cos(0.5 * yaw);
  const double sine = std::sin(0.5 * yaw);
  return {cosine * cosine - sine * sine, 2.0 * cosine * sine};
}
inline Heading<simd::Lanes> headingOf(const simd::Lanes& yaw) {
  Heading<simd::Lanes> result;
  for (int lane = 0; lane < simd::kLaneCount; ++lane) {
    const Heading<double> one = headingOf(static_cast<double>(yaw[lane]));
    result.cosine[lane] = one.cosine;
    result.sine[lane] = one.sine;
  }
  return result;
}

template <class Real>
Tee<Real> teeOf(const Vector<Real>& positions) {
  const Heading<Real> heading = headingOf(positions[kTeeYaw]);
  return {{positions[kTeeX], positions[kTeeY]},
          heading,
          {kCenterOfMassOffset * heading.sine, -kCenterOfMassOffset * heading.cosine}};
}

template <class Real>
Matrix<Real> massMatrix(const Model& model, const Tee<Real>& tee) {
  const Real zero(0.0);
  const Real tee_mass(model.tee_mass);
  const Real pusher_mass(model.pusher_mass);
  const Vector2<Real> moment = scaled<Real>(tee_mass, tee.centre_of_mass);  // [kg m], the first one
  return {Vector<Real>{tee_mass, zero, -moment.y(), zero, zero}, Vector<Real>{zero, tee_mass, moment.x(), zero, zero},
          Vector<Real>{-moment.y(), moment.x(), Real(model.tee_moment), zero, zero},
          Vector<Real>{zero, zero, zero, pusher_mass, zero}, Vector<Real>{zero, zero, zero, zero, pusher_mass}};
}

/// [N, N m] All forces but those of constraints: drag and centrifugal force on the tee, the pusher's servo.
template <class Real>
Vector<Real> smoothForce(const Model& model, const Tee<Real>& tee, const Matrix<Real>& mass,
                         const Vector<Real>& velocities, const Vector2<Real>& command) {
  const Vector<Real> momentum = product<Real>(mass, velocities);
  const Real& spin = velocities[kTeeYaw];
  const Vector2<Real> centrifugal = scaled<Real>(model.tee_mass * spin * spin, tee.centre_of_mass);
  Vector<Real> force;
  force[kTeeX] = centrifugal.x() - model.tee_damping * velocities[kTeeX] - model.drag_rate * momentum[kTeeX];
  force[kTeeY] = centrifugal.y() - model.tee_damping * velocities[kTeeY] - model.drag_rate * momentum[kTeeY];
  force[kTeeYaw] = -model.tee_yaw_damping * spin - model.drag_rate * momentum[kTeeYaw];
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const Real& velocity = velocities[kPusherX + axis];
    const Real pull = model.servo_gain * (command[static_cast<Eigen::Index>(axis)] - velocity);
    const Real limited = select(pull > model.servo_limit, Real(model.servo_limit),
                                select(pull < -model.servo_limit, Real(-model.servo_limit), pull));
    force[kPusherX + axis] = limited - model.pusher_damping * velocity;
  }
  return force;
}

/// Acceleration of the implicit integrator: (M - h D) a = `force`, where D is the derivative of the smooth force by the
/// velocities. D keeps the servo's part where its force is at its limit, as MuJoCo's does.
template <class Real>
Vector<Real> implicitAcceleration(const Model& model, const Tee<Real>& tee, const Matrix<Real>& mass,
                                  const Vector<Real>& velocities, const Vector<Real>& force) {
  // The tee's rows are (d, 0, p), (0, d, q), (r, s, t); the first two are put into the third.
  const Vector2<Real> centrifugal = scaled<Real>(2.0 * model.tee_mass * velocities[kTeeYaw], tee.centre_of_mass);
  const Real d(model.tee_mass + kSubstep * model.tee_damping);
  const Real p = mass[kTeeX][kTeeYaw] - kSubstep * centrifugal.x();
  const Real q = mass[kTeeY][kTeeYaw] - kSubstep * centrifugal.y();
  const Real r = mass[kTeeYaw][kTeeX] / d;
  const Real s = mass[kTeeYaw][kTeeY] / d;
  const Real t = mass[kTeeYaw][kTeeYaw] + kSubstep * model.tee_yaw_damping;
  Vector<Real> acceleration;
  acceleration[kTeeYaw] = (force[kTeeYaw] - r * force[kTeeX] - s * force[kTeeY]) / (t - r * p - s * q);
  acceleration[kTeeX] = (force[kTeeX] - p * acceleration[kTeeYaw]) / d;
  acceleration[kTeeY] = (force[kTeeY] - q * acceleration[kTeeYaw]) / d;
  const double pusher = model.pusher_mass + kSubstep * model.servo_derivative;
  acceleration[kPusherX] = force[kPusherX] / pusher;
  acceleration[kPusherY] = force[kPusherY] / pusher;
  return acceleration;
}

/// Dry friction of the table on each coordinate of the tee: a force against the motion, up to a limit.
template <class Real>
void addDryFriction(const Model& model, const Vector<Real>& velocities, Rows<Real>& rows) {
  const Real zero(0.0);
  const Real one(1.0);
  for (std::size_t i = 0; i < model.dry_friction.size(); ++i) {
    Vector<Real> jacobian = {zero, zero, zero, zero, zero};
    jacobian[i] = one;
    rows.add({Condition<Real>(true), jacobian, -soft::kDamping * velocities[i], Real(model.dry_friction_regularity[i]),
              Real(-model.dry_friction[i]), Real(model.dry_friction[i])});
  }
}

/// [-] How much of a missing acceleration a soft contact makes up, by its depth.
template <class Real>
Real impedance(const Real& depth) {
  const Real x = select(depth < soft::kWidth, depth / soft::kWidth, Real(1.0));
  const Real rise = select(x < 0.5, 2.0 * x * x, 1.0 - 2.0 * (1.0 - x) * (1.0 - x));
  return soft::kLeastImpedance + rise * (soft::kImpedance - soft::kLeastImpedance);
}

/// Which bodies a contact is between, and how large accelerations there are for a force [1/kg].
struct Pair {
  bool tee;     ///< is pushed along the normal; else the pusher is
  bool pusher;  ///< is pushed against it, or along it if the tee is not there
  double weight;
};

/// The acceleration of the contact along `direction`, by those of the coordinates.
template <class Real>
Vector<Real> jacobianAlong(const Vector2<Real>& direction, const Vector2<Real>& arm, const Pair& pair) {
  const Real zero(0.0);
  Vector<Real> jacobian = {zero, zero, zero, zero, zero};
  if (pair.tee) {
    jacobian[kTeeX] = direction.x();
    jacobian[kTeeY] = direction.y();
    jacobian[kTeeYaw] = arm.x() * direction.y() - arm.y() * direction.x();
  }
  if (pair.pusher) {
    jacobian[kPusherX] = pair.tee ? -direction.x() : direction.x();
    jacobian[kPusherY] = pair.tee ? -direction.y() : direction.y();
  }
  return jacobian;
}

/// `multiplicity` contacts at the same place. With friction, MuJoCo's pyramid of four edges: in the plane two slant to
/// either side, and two, which slant up and down, are both the normal.
template <class Real>
void addContact(const Model& model, const Contact<Real>& contact, const Vector2<Real>& tee_origin, const Pair& pair,
                const Vector<Real>& velocities, double multiplicity, Rows<Real>& rows) {
  if (!any(contact.touching)) {
    return;
  }
  const Real most(std::numeric_limits<double>::infinity());
  const Real zero(0.0);
  const bool is_soft = model.switches.softness;
  const Real hardness = is_soft ? impedance(contact.depth) : Real(1.0 - simple::kCompliance);
  const Real spring = is_soft ? Real(soft::kStiffness * hardness * contact.depth)
                              : Real(simple::kOverlapShare / (kSubstep * kSubstep) * contact.depth);
  const double damping = is_soft ? soft::kDamping : 1.0 / kSubstep;
  const Real stiffness = multiplicity / pair.weight * hardness / (1.0 - hardness);
  const Vector2<Real> arm = contact.point - tee_origin;

  const auto add = [&](const Vector2<Real>& direction, const Real& of_edge) {
    const Vector<Real> jacobian = jacobianAlong(direction, arm, pair);
    rows.add({contact.touching, jacobian, spring - damping * dot<Real>(jacobian, velocities), of_edge, zero, most});
  };
  if (!model.switches.friction) {
    add(contact.normal, stiffness);
    return;
  }
  constexpr double kMu = dynamics::kContactFriction;
  const Real of_edge = stiffness / (2.0 * kMu * kMu * (1.0 + kMu * kMu));
  const Vector2<Real> slanted = {-kMu * contact.normal.y(), kMu * contact.normal.x()};
  add(contact.normal + slanted, of_edge);
  add(contact.normal - slanted, of_edge);
  add(contact.normal, 2.0 * of_edge);
}

/// Of a world as it is in a substep, for those who look for contacts in it.
template <class Real>
struct Scene {
  Vector2<Real> pusher;
  const Model& model;
  const Tee<Real>& tee;
  double margin;  ///< [m] bodies closer than this touch
};

/// The pusher and a part of the tee; pushes the tee.
template <class Real>
Contact<Real> touchTee(const Scene<Real>& scene, const Part& part) {
  const auto& [origin, heading, centre_of_mass] = scene.tee;
  const Vector2<Real> centre = centreOf(part, origin, heading);
  if (!scene.model.switches.shape) {
    return touchDiscs<Real>(centre, part.disc_radius, scene.pusher, kPusherRadius, scene.margin);
  }
  Contact<Real> contact = touchNearest<Real>(scene.pusher, kPusherRadius, part.box, centre, heading, scene.margin);
  if (scene.model.switches.narrow_phase) {
    refine(scene.pusher, part.box, centre, heading, contact);
  }
  return contact;
}

/// Pusher and wall; pushes the pusher.
template <class Real>
Contact<Real> touchWall(const Scene<Real>& scene, const Wall& wall) {
  Contact<Real> contact = touchWall<Real>(scene.pusher, kPusherRadius, wall, scene.margin);
  if (scene.model.switches.narrow_phase && any(contact.touching)) {
    const Eigen::Vector2d centre = wall.centre();
    contact.normal = -contact.normal;
    refine(scene.pusher, wall.box(), {Real(centre.x()), Real(centre.y())}, {Real(1.0), Real(0.0)}, contact);
    contact.normal = -contact.normal;
  }
  return contact;
}

/// Part of the tee and wall: disc and wall, or the box's corners, one by one. MuJoCo finds the edge at each corner
/// twice, at its ends, and half as deep as it is.
template <class Real>
void addTeeAtWall(const Scene<Real>& scene, const Part& part, const Wall& wall, const Vector<Real>& velocities,
                  Rows<Real>& rows) {
  const auto& [origin, heading, centre_of_mass] = scene.tee;
  const Model& model = scene.model;
  const Pair pair = {true, false, model.tee_wall_weight};
  const Vector2<Real> centre = centreOf(part, origin, heading);
  if (!any(touchWall<Real>(centre, part.reach(), wall, scene.margin).touching)) {
    return;
  }
  if (!model.switches.shape) {
    addContact(model, touchWall<Real>(centre, part.disc_radius, wall, scene.margin), origin, pair, velocities, 1.0,
               rows);
    return;
  }
  for (const double x : {part.box.half_x, -part.box.half_x}) {
    for (const double y : {part.box.half_y, -part.box.half_y}) {
      const Vector2<Real> corner = centre + heading.toTable({Real(x), Real(y)});
      Contact<Real> contact = touchWall<Real>(corner, 0.0, wall, scene.margin);
      if (model.switches.narrow_phase) {
        contact.depth *= 0.5;
      }
      addContact(model, contact, origin, pair, velocities, model.switches.narrow_phase ? 2.0 : 1.0, rows);
    }
  }
}

template <class Real>
Rows<Real> constraintsOf(const Scene<Real>& scene, const Vector<Real>& velocities) {
  const Model& model = scene.model;
  const Vector2<Real>& origin = scene.tee.origin;
  Rows<Real> rows;
  if (model.switches.coulomb) {
    addDryFriction(model, velocities, rows);
  }
  for (const Part& part : kParts) {
    addContact(model, touchTee(scene, part), origin, {true, true, model.tee_pusher_weight}, velocities, 1.0, rows);
  }
  if (model.switches.walls) {
    for (const Wall& wall : kWalls) {
      addContact(model, touchWall(scene, wall), origin, {false, true, model.pusher_wall_weight}, velocities, 1.0, rows);
      for (const Part& part : kParts) {
        addTeeAtWall(scene, part, wall, velocities, rows);
      }
    }
  }
  return rows;
}

/// One substep in which the pusher is to move with velocity `command` [m/s].
template <class Real>
void substep(const Model& model, const Vector2<Real>& command, Bodies<Real>& bodies) {
  auto& [positions, velocities] = bodies;
  const Tee<Real> tee = teeOf(positions);
  const Matrix<Real> mass = massMatrix(model, tee);
  Vector<Real> force = smoothForce(model, tee, mass, velocities, command);

  // Forces that hold the constraints: the table's friction, contacts between bodies.
  const Scene<Real> scene = {
      {positions[kPusherX], positions[kPusherY]}, model, tee, model.switches.softness ? 0.0 : simple::kMargin};
  const Vector<Real> constraint = constraintForce<Real>(mass, force, constraintsOf(scene, velocities));

  // Velocities by the implicit integrator, positions by velocities.
  for (std::size_t i = 0; i < kCoordinateCount; ++i) {
    force[i] += constraint[i];
  }
  const Vector<Real> acceleration = implicitAcceleration(model, tee, mass, velocities, force);
  for (std::size_t i = 0; i < kCoordinateCount; ++i) {
    velocities[i] += kSubstep * acceleration[i];
    positions[i] += kSubstep * velocities[i];
  }
}

}  // namespace pusht::rigid_body
