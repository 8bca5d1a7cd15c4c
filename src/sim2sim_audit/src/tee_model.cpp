// SPDX-License-Identifier: BSD-3-Clause
#include "tee_model.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "pusht_task/constants.hpp"
#include "pusht_task/mujoco_constraint.hpp"
#include "pusht_task/physics.hpp"

namespace sim2sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// [m] From the tee origin to a point of the body's axis, in table axes.
Eigen::Vector2d armOf(double point, double yaw) { return point * Eigen::Vector2d(std::sin(yaw), -std::cos(yaw)); }

/// Velocity of a point, and the yaw rate, per velocity of the tee.
Matrix3d jacobianOf(double point, double yaw) {
  const Eigen::Vector2d arm = armOf(point, yaw);
  Matrix3d jacobian = Matrix3d::Identity();
  jacobian(0, 2) = -arm.y();
  jacobian(1, 2) = arm.x();
  return jacobian;
}

/// [m/s^2, m/s^2, m^2/s^2] Nearest friction within the limits.
void limit(Vector3d& friction, const TeeNumbers& numbers, bool disc) {
  const double most_x = std::max(0.0, numbers.friction_x);
  const double most_y = std::max(0.0, numbers.friction_y);
  const double most_yaw = std::max(0.0, numbers.yaw_friction);
  friction[2] = std::clamp(friction[2], -most_yaw, most_yaw);
  if (!disc) {
    friction[0] = std::clamp(friction[0], -most_x, most_x);
    friction[1] = std::clamp(friction[1], -most_y, most_y);
  } else if (const double size = friction.head<2>().norm(); size > 0.5 * (most_x + most_y)) {
    friction.head<2>() *= 0.5 * (most_x + most_y) / size;
  }
}

/// Friction for which response * friction is `wanted`, as far as its limits go. A limit in every direction takes both
/// axes at once: one after the other would turn what is far beyond it towards the last.
Vector3d frictionFor(const TeeNumbers& numbers, bool disc, const Matrix3d& response, const Vector3d& wanted) {
  constexpr int kSweeps = 300;
  constexpr double kConverged = 1e-13;
  Vector3d friction = Vector3d::Zero();
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const Vector3d before = friction;
    if (disc) {
      const double stiffest = std::max(response(0, 0), response(1, 1));
      friction.head<2>() += (wanted - response * friction).head<2>() / stiffest;
      limit(friction, numbers, disc);
    }
    for (Eigen::Index i = disc ? 2 : 0; i < 3; ++i) {
      friction[i] += (wanted[i] - response.row(i).dot(friction)) / response(i, i);
      limit(friction, numbers, disc);
    }
    if ((friction - before).cwiseAbs().maxCoeff() <= kConverged * (1.0 + friction.cwiseAbs().maxCoeff())) {
      break;
    }
  }
  return friction;
}

/// Friction that fades with the slip [m/s, m/s, rad/s].
Vector3d smoothFriction(const TeeNumbers& numbers, const TeeModelForm& form, const Vector3d& slip) {
  const double speed = slip.head<2>().norm();
  const double of_disc = 0.5 * (numbers.friction_x + numbers.friction_y) * std::tanh(speed / numbers.smoothing);
  const auto along = [&](Eigen::Index axis, double most) {
    const double of_axis = most * std::tanh(slip[axis] / numbers.smoothing);
    return form.disc_friction ? of_disc * slip[axis] / std::max(speed, 1e-12) : of_axis;
  };
  return {-along(0, numbers.friction_x), -along(1, numbers.friction_y),
          -numbers.yaw_friction * std::tanh(slip[2] / numbers.yaw_smoothing)};
}

/// Compliance of MuJoCo's friction, of each coordinate: a share of the inverse inertia at yaw 0.
Vector3d complianceOf(const TeeNumbers& numbers) {
  using namespace pusht::mujoco_constraint;
  const double center = numbers.center_of_mass;
  const Vector3d weight(1.0 + center * center / numbers.moment, 1.0, 1.0 / numbers.moment);
  return pusht::mujoco_constraint::complianceOf(kImpedance) * weight;
}

/// Inertia per mass about the tee origin: of the tee, or of one with more mass at some place.
Matrix3d inertiaOf(double mass, const Eigen::Vector2d& first_moment, double second_moment) {
  Matrix3d inertia = mass * Matrix3d::Identity();
  inertia(0, 2) = inertia(2, 0) = -first_moment.y();
  inertia(1, 2) = inertia(2, 1) = first_moment.x();
  inertia(2, 2) = second_moment;
  return inertia;
}

/// Damping per mass: force on the tee origin per velocity of it.
Matrix3d dampingOf(const TeeNumbers& numbers, double yaw) {
  const Matrix3d at_point = jacobianOf(numbers.damping_point, yaw);
  return at_point.transpose() * Vector3d(numbers.damping, numbers.damping, numbers.yaw_damping).asDiagonal() * at_point;
}

/// Constraints see the inertia alone.
void substepOfJoints(const TeeNumbers& numbers, const TeeModelForm& form, double duration, TeeMotion& motion) {
  const double yaw = motion.pose[2];
  const double yaw_rate = motion.velocity[2];
  const Eigen::Vector2d center = armOf(numbers.center_of_mass, yaw);
  const Matrix3d inertia = inertiaOf(1.0, center, numbers.moment + numbers.center_of_mass * numbers.center_of_mass);
  const Matrix3d damping = dampingOf(numbers, yaw);
  Vector3d force = -damping * motion.velocity;
  force.head<2>() += yaw_rate * yaw_rate * center;  // centrifugal
  Matrix3d by_velocity = -damping;                  // derivative of what acts at the end of the substep
  if (form.integrator == TeeIntegrator::kImplicitJoints) {
    by_velocity.topRightCorner<2, 1>() += 2.0 * yaw_rate * center;
  }
  const Matrix3d at_friction = jacobianOf(numbers.friction_point, yaw);
  const Matrix3d free = inertia.inverse();
  Matrix3d response = at_friction * free * at_friction.transpose();
  response.diagonal() += complianceOf(numbers);
  const Vector3d slip = at_friction * motion.velocity;
  const Vector3d friction =
      form.smooth_friction ? smoothFriction(numbers, form, slip)
                           : frictionFor(numbers, form.disc_friction, response,
                                         -pusht::mujoco_constraint::kDamping * slip - at_friction * (free * force));
  motion.velocity +=
      duration * ((inertia - duration * by_velocity).inverse() * (force + at_friction.transpose() * friction));
  motion.pose += duration * motion.velocity;
}

/// Implicit damping is damping at the substep's begin of a tee that is heavier by what it takes in a substep. The
/// center of that tee moves straight on, and the tee turns about it.
void substepOfBody(const TeeNumbers& numbers, const TeeModelForm& form, double duration, TeeMotion& motion) {
  const double yaw = motion.pose[2];
  const double added = duration * numbers.damping;
  const double mass = 1.0 + added;
  const double center_of_all = (numbers.center_of_mass + added * numbers.damping_point) / mass;  // [m] along -y
  const double second_moment = numbers.moment + numbers.center_of_mass * numbers.center_of_mass +
                               duration * numbers.yaw_damping + added * numbers.damping_point * numbers.damping_point;
  const Eigen::Vector2d arm = armOf(center_of_all, yaw);
  const Matrix3d mobility = inertiaOf(mass, mass * arm, second_moment).inverse();
  const Matrix3d at_friction = jacobianOf(numbers.friction_point, yaw);
  const Vector3d damped = motion.velocity - duration * (mobility * (dampingOf(numbers, yaw) * motion.velocity));
  const Vector3d friction =
      form.smooth_friction ? smoothFriction(numbers, form, at_friction * motion.velocity)
                           : frictionFor(numbers, form.disc_friction, at_friction * mobility * at_friction.transpose(),
                                         -at_friction * damped / duration);
  const Vector3d velocity = damped + duration * (mobility * (at_friction.transpose() * friction));
  // The center's velocity does not change when the tee turns.
  const auto of_center_at = [&arm](const Vector3d& v) {
    return Eigen::Vector2d(v.head<2>() + v[2] * Eigen::Vector2d(-arm.y(), arm.x()));
  };
  const Eigen::Vector2d of_center = of_center_at(velocity);
  const Vector3d& moves_with = form.moves_first ? motion.velocity : velocity;
  const double turned = yaw + duration * moves_with[2];
  const Eigen::Vector2d new_arm = armOf(center_of_all, turned);
  motion.pose.head<2>() += arm + duration * of_center_at(moves_with) - new_arm;
  motion.pose[2] = turned;
  motion.velocity.head<2>() = of_center - velocity[2] * Eigen::Vector2d(-new_arm.y(), new_arm.x());
  motion.velocity[2] = velocity[2];
}

}  // namespace

TeeNumbers TeeNumbers::of(const pusht::Physics& task) {
  const double mass = task.tee_mass;
  const double center = task.centerOfMass();
  return {center,
          task.tee_second_moment / mass - center * center,
          task.tee_damping / mass,
          task.tee_yaw_damping / mass,
          task.tee_friction[0] / mass,
          task.tee_friction[1] / mass,
          task.tee_yaw_friction / mass,
          task.table_point,
          task.table_point,
          0.05,
          0.5};
}

TeeNumbers::Vector TeeNumbers::scale() {
  const TeeNumbers task = of(pusht::Physics());
  Vector scale;
  scale << task.center_of_mass, task.moment, task.damping, task.yaw_damping, task.friction_x, task.friction_y,
      task.yaw_friction, task.center_of_mass, task.center_of_mass, task.smoothing, task.yaw_smoothing;
  return scale;
}

TeeNumbers::Vector TeeNumbers::toVector() const {
  Vector vector;
  vector << center_of_mass, moment, damping, yaw_damping, friction_x, friction_y, yaw_friction, damping_point,
      friction_point, smoothing, yaw_smoothing;
  return vector.cwiseQuotient(scale());
}

TeeNumbers TeeNumbers::fromVector(const Vector& vector) {
  const Vector v = vector.cwiseProduct(scale());
  return {v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8], v[9], v[10]};
}

TeeMotion TeeMotion::of(const pusht::WorldState& state) {
  return {{state.tee_position.x(), state.tee_position.y(), state.tee_yaw},
          {state.tee_velocity.x(), state.tee_velocity.y(), state.tee_yaw_rate}};
}

TeeMotion controlStep(const TeeNumbers& numbers, const TeeModelForm& form, TeeMotion motion) {
  const auto substep = form.integrator == TeeIntegrator::kBody ? substepOfBody : substepOfJoints;
  for (int i = 0; i < form.substeps; ++i) {
    substep(numbers, form, pusht::kControlStep / form.substeps, motion);
  }
  return motion;
}

}  // namespace sim2sim
