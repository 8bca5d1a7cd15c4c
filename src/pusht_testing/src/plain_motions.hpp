// SPDX-License-Identifier: BSD-3-Clause
/// Motions that follow from the physics of a kind by plain formulas.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "pusht_task/constants.hpp"
#include "pusht_task/mujoco_constraint.hpp"
#include "pusht_testing/physics_of_kind.hpp"

namespace pusht::testing {

/// One axis of the pusher in free space.
struct PlainPusher {
  double position;  ///< [m]
  double velocity;  ///< [m/s]

  void controlStep(const PhysicsOfKind& physics, double command) {
    const Physics& p = physics.numbers;
    const double inertia =
        p.pusher_mass + (physics.implicit_servo ? kSubstep * (p.servo_gain + p.pusher_damping) : 0.0);  // [kg]
    for (int i = 0; i < kSubstepsPerControlStep; ++i) {
      const double servo = std::clamp(p.servo_gain * (command - velocity), -p.servo_limit, p.servo_limit);
      velocity += kSubstep * (servo - p.pusher_damping * velocity) / inertia;
      position += kSubstep * velocity;
    }
  }
};

/// The pusher behind the tee, which it pushes straight through the tee's center of mass: one body along one axis.
struct PlainPush {
  double travel = 0.0;    ///< [m]
  double velocity = 0.0;  ///< [m/s]

  void controlStep(const PhysicsOfKind& physics, double command, double tee_friction) {
    const Physics& p = physics.numbers;
    const double servo = p.servo_gain + p.pusher_damping;
    const double damping = servo + p.tee_damping;
    const double inertia = p.pusher_mass + p.tee_mass + kSubstep * p.tee_damping +
                           (physics.implicit_servo ? kSubstep * servo : 0.0);  // [kg]
    for (int i = 0; i < kSubstepsPerControlStep; ++i) {
      const double force =
          p.servo_gain * command - tee_friction - (damping + physics.drag_rate * p.tee_mass) * velocity;
      velocity = std::max(0.0, velocity + kSubstep * force / inertia);
      travel += kSubstep * velocity;
    }
  }
};

/// The tee alone on its table: Newton and Euler about the tee origin, with friction of the table solved by
/// Gauss-Seidel.
struct PlainTee {
  Eigen::Vector3d pose;      ///< [m, m, rad]
  Eigen::Vector3d velocity;  ///< per second

  void controlStep(const PhysicsOfKind& physics) {
    for (int i = 0; i < kSubstepsPerControlStep; ++i) {
      substep(physics);
    }
  }

  void substep(const PhysicsOfKind& physics) {
    velocity += kSubstep * acceleration(physics, kSubstep);
    pose += kSubstep * velocity;
  }

  /// [m/s^2, m/s^2, rad/s^2] Acceleration over a substep of that length [s], with implicit damping. Length 0: at this
  /// instant, for kinds whose friction with the table is soft or none.
  Eigen::Vector3d acceleration(const PhysicsOfKind& physics, double substep) const {
    const Physics& p = physics.numbers;
    const Eigen::Vector2d moment = p.tee_first_moment * Eigen::Vector2d(std::sin(pose[2]), -std::cos(pose[2]));
    Eigen::Matrix3d inertia;
    inertia << p.tee_mass, 0.0, -moment.y(),  //
        0.0, p.tee_mass, moment.x(),          //
        -moment.y(), moment.x(), p.tee_second_moment;
    const Eigen::DiagonalMatrix<double, 3> damping(p.tee_damping, p.tee_damping, p.tee_yaw_damping);
    Eigen::Vector3d force = -(damping * velocity) - physics.drag_rate * (inertia * velocity);
    force.head<2>() += velocity[2] * velocity[2] * moment;  // centrifugal
    const Eigen::Matrix3d mobility = (inertia + substep * Eigen::Matrix3d(damping)).inverse();
    if (physics.soft_friction) {
      force += softFriction(p, inertia.inverse(), force);
    } else if (substep > 0.0) {
      force += hardFriction(p, mobility, force, substep);
    }
    return mobility * force;
  }

 private:
  /// [N, N, N m] Coulomb friction that stops each coordinate in this substep [s], as far as its limit goes.
  Eigen::Vector3d hardFriction(const Physics& p, const Eigen::Matrix3d& mobility, const Eigen::Vector3d& force,
                               double substep) const {
    return limitedForce(p, mobility, -velocity / substep - mobility * force);
  }

  /// MuJoCo's constraint for `frictionloss`.
  Eigen::Vector3d softFriction(const Physics& p, const Eigen::Matrix3d& inverse_inertia,
                               const Eigen::Vector3d& force) const {
    const double center = p.centerOfMass();
    const double about_center = p.tee_second_moment - p.tee_mass * center * center;  // [kg m^2]
    const Eigen::Vector3d weight(1.0 / p.tee_mass + center * center / about_center, 1.0 / p.tee_mass,
                                 1.0 / about_center);  // the inverse inertia at yaw 0
    const Eigen::Vector3d wanted = -mujoco_constraint::kDamping * velocity;
    Eigen::Matrix3d response = inverse_inertia;
    response.diagonal() += mujoco_constraint::complianceOf(mujoco_constraint::kImpedance) * weight;
    return limitedForce(p, response, wanted - inverse_inertia * force);
  }

  /// The force for which response * force is `wanted`, each coordinate limited: by Gauss-Seidel.
  static Eigen::Vector3d limitedForce(const Physics& p, const Eigen::Matrix3d& response,
                                      const Eigen::Vector3d& wanted) {
    constexpr int kSweeps = 1000;
    const Eigen::Vector3d limits(p.tee_friction[0], p.tee_friction[1], p.tee_yaw_friction);
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      const Eigen::Vector3d before = force;
      for (Eigen::Index i = 0; i < 3; ++i) {
        const double missing = wanted[i] - response.row(i).dot(force);
        force[i] = std::clamp(force[i] + missing / response(i, i), -limits[i], limits[i]);
      }
      if (force == before) {
        break;
      }
    }
    return force;
  }
};

}  // namespace pusht::testing
