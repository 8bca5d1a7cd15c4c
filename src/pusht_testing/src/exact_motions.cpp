// SPDX-License-Identifier: BSD-3-Clause
#include "exact_motions.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <cmath>
#include <cstddef>

#include "plain_motions.hpp"
#include "pusht_task/mujoco_constraint.hpp"

namespace pusht::testing {
namespace {

/// Body on a line under viscous and constant friction: v' = -rate v + drive.
struct Linear {
  double rate;   ///< [1/s], above 0
  double drive;  ///< [m/s^2]

  double velocity(double start, double time) const {
    return drive / rate + (start - drive / rate) * std::exp(-rate * time);
  }
  double travel(double start, double time) const {
    return drive / rate * time - (start - drive / rate) * std::expm1(-rate * time) / rate;
  }
  /// [s] Time until the velocity is `wanted`, which lies between `start` and drive / rate.
  double timeUntil(double wanted, double start) const {
    return std::log((start - drive / rate) / (wanted - drive / rate)) / rate;
  }
};

/// State after `duration` [s] of x' = derivative(x), by Dormand and Prince with steps of its own choice. Where the
/// derivative has a kink, steps get short.
template <std::size_t N, class Derivative>
std::array<double, N> integrated(std::array<double, N> state, double duration, const Derivative& derivative) {
  namespace odeint = boost::numeric::odeint;
  constexpr double kTolerance = 1e-13;
  constexpr double kFirstStep = 1e-6;  // [s]
  using Stepper = odeint::runge_kutta_dopri5<std::array<double, N>>;
  odeint::integrate_adaptive(
      odeint::make_controlled<Stepper>(kTolerance, kTolerance),
      [&](const std::array<double, N>& x, std::array<double, N>& rate, double /*time*/) { rate = derivative(x); },
      state, 0.0, duration, kFirstStep);
  return state;
}

/// The tee on its own, the pusher out of its way.
WorldState teeAlone(double y, double speed_along_y, double yaw_rate) {
  WorldState start;
  start.tee_position.y() = y;
  start.tee_velocity.y() = speed_along_y;
  start.tee_yaw_rate = yaw_rate;
  start.pusher_position = {0.2, 0.2};
  return start;
}

/// The pusher in free space, from rest. Closed form: it approaches its speed with the rate (gain + damping) / mass.
std::optional<ExactMotion> servo(const PhysicsOfKind& physics) {
  const Physics& p = physics.numbers;
  ExactMotion motion = {{}, {0.6F, 0.0F}, 1, {}};
  motion.start.pusher_position = {-0.2, -0.2};
  const Linear pusher = {(p.servo_gain + p.pusher_damping) / p.pusher_mass,
                         p.servo_gain * motion.action[0] / p.pusher_mass};
  motion.end = motion.start;
  motion.end.pusher_position.x() += pusher.travel(0.0, motion.duration());
  return motion;
}

/// The pusher in free space, at first so much too fast that its servo is at its limit. Closed form, in two parts.
std::optional<ExactMotion> servoAtItsLimit(const PhysicsOfKind& physics) {
  const Physics& p = physics.numbers;
  if (std::isinf(p.servo_limit)) {
    return std::nullopt;
  }
  constexpr double kSpeed = -6.0;  // [m/s]
  ExactMotion motion = {{}, {0.6F, 0.0F}, 1, {}};
  motion.start.pusher_position = {0.3, 0.2};
  motion.start.pusher_velocity.x() = kSpeed;
  const Linear limited = {p.pusher_damping / p.pusher_mass, p.servo_limit / p.pusher_mass};
  const Linear free = {(p.servo_gain + p.pusher_damping) / p.pusher_mass,
                       p.servo_gain * motion.action[0] / p.pusher_mass};
  const double end_of_limit = motion.action[0] - p.servo_limit / p.servo_gain;  // [m/s]
  const double time = limited.timeUntil(end_of_limit, kSpeed);                  // [s]
  motion.end = motion.start;
  motion.end.pusher_position.x() += limited.travel(kSpeed, time) + free.travel(end_of_limit, motion.duration() - time);
  return motion;
}

/// [m] Travel of the tee, left alone, along the line of its centers at yaw 0, which does not turn it. Closed form.
/// Coulomb friction stops it at a finite time. MuJoCo's has its limit down to a speed, and below that it is viscous:
/// the tee never stops.
double slideOf(const PhysicsOfKind& physics, double speed, double duration) {
  const Physics& p = physics.numbers;
  const double damping_rate = p.tee_damping / p.tee_mass + physics.drag_rate;
  const double friction = p.tee_friction[1] / p.tee_mass;  // [m/s^2]
  const Linear sliding = {damping_rate, -friction};
  if (friction == 0.0) {
    return sliding.travel(speed, duration);
  }
  double slow = 0.0;  // [m/s] speed at which this friction ends
  Linear creeping = {1.0, 0.0};
  if (physics.soft_friction) {
    // Below the limit the acceleration a is for which impedance (-kDamping v - a0) = a - a0, a0 = -damping_rate v.
    using namespace mujoco_constraint;
    slow = friction / (kImpedance * (kDamping - damping_rate));
    creeping.rate = (1.0 - kImpedance) * damping_rate + kImpedance * kDamping;
  }
  const double slow_from = sliding.timeUntil(slow, speed);
  if (slow_from >= duration) {
    return sliding.travel(speed, duration);
  }
  return sliding.travel(speed, slow_from) + creeping.travel(slow, duration - slow_from);
}

/// A tee that slides along y from this speed [m/s], against both frictions.
ExactMotion slideAt(const PhysicsOfKind& physics, double speed) {
  ExactMotion motion = {teeAlone(-0.28, speed, 0.0), {0.0F, 0.0F}, 1, {}};
  motion.end = motion.start;
  motion.end.tee_position.y() += slideOf(physics, speed, motion.duration());
  return motion;
}
/// The tee slides, and still does so at the end: a smooth motion.
std::optional<ExactMotion> slide(const PhysicsOfKind& physics) { return slideAt(physics, 24.0); }
/// The tee slides until friction has stopped it.
std::optional<ExactMotion> slideToRest(const PhysicsOfKind& physics) { return slideAt(physics, 1.0); }

/// The tee turns about its origin. With Coulomb friction it has a closed form: friction holds the origin, which needs
/// 1.0 of 1.2 N, and the yaw stops at a finite time. Otherwise the origin moves: the differential equation of PlainTee.
std::optional<ExactMotion> spin(const PhysicsOfKind& physics) {
  const Physics& p = physics.numbers;
  constexpr double kRate = 4.0;  // [rad/s]
  ExactMotion motion = {teeAlone(0.0, 0.0, kRate), {0.0F, 0.0F}, 1, {}};
  motion.end = motion.start;
  if (!physics.soft_friction && p.tee_yaw_friction > 0.0) {
    const Linear turning = {p.tee_yaw_damping / p.tee_second_moment, -p.tee_yaw_friction / p.tee_second_moment};
    motion.end.tee_yaw = turning.travel(kRate, std::min(turning.timeUntil(0.0, kRate), motion.duration()));
    return motion;
  }
  const auto end = integrated<6>({0.0, 0.0, 0.0, 0.0, 0.0, kRate}, motion.duration(), [&](const auto& x) {
    const PlainTee tee = {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}};
    const Eigen::Vector3d acceleration = tee.acceleration(physics, 0.0);
    return std::array<double, 6>{x[3], x[4], x[5], acceleration[0], acceleration[1], acceleration[2]};
  });
  motion.end.tee_position += Eigen::Vector2d(end[0], end[1]);
  motion.end.tee_yaw = end[2];
  return motion;
}

/// Pusher and tee along one axis, the pusher behind the tee's center of mass: MuJoCo's contact and its friction with
/// the table, as accelerations of tee and pusher [m/s^2].
struct SoftPush {
  const PhysicsOfKind& physics;
  double command;  ///< [m/s]

  std::array<double, 2> accelerations(double overlap, double tee_speed, double pusher_speed) const {
    using namespace mujoco_constraint;
    constexpr int kSweeps = 1000;
    const Physics& p = physics.numbers;
    const double servo = std::clamp(p.servo_gain * (command - pusher_speed), -p.servo_limit, p.servo_limit);
    const double on_pusher = servo - p.pusher_damping * pusher_speed;                     // [N]
    const double on_tee = -(p.tee_damping + physics.drag_rate * p.tee_mass) * tee_speed;  // [N]
    const double x = std::clamp(overlap / kWidth, 0.0, 1.0);
    const double rise = x < 0.5 ? 2.0 * x * x : 1.0 - 2.0 * (1.0 - x) * (1.0 - x);
    const double impedance = kImpedance + rise * (kMostImpedance - kImpedance);
    const double both = 1.0 / p.tee_mass + 1.0 / p.pusher_mass;            // [1/kg]
    const double compliance = complianceOf(impedance) * 2.0 / 3.0 * both;  // [1/kg] of the contact
    const double wanted = kStiffness * impedance * overlap - kDamping * (tee_speed - pusher_speed);
    const double table_compliance = complianceOf(kImpedance) / p.tee_mass;  // [1/kg]
    double push = 0.0;                                                      // [N]
    double friction = 0.0;                                                  // [N]
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      const std::array<double, 2> before = {push, friction};
      const double free = (on_tee + friction) / p.tee_mass - on_pusher / p.pusher_mass;
      push = overlap > 0.0 ? std::max(0.0, (wanted - free) / (both + compliance)) : 0.0;
      friction =
          std::clamp((-kDamping * tee_speed - (on_tee + push) / p.tee_mass) / (1.0 / p.tee_mass + table_compliance),
                     -p.tee_friction[1], p.tee_friction[1]);
      if (before == std::array<double, 2>{push, friction}) {
        break;
      }
    }
    return {(on_tee + push + friction) / p.tee_mass, (on_pusher - push) / p.pusher_mass};
  }
};

/// The pusher, at speed, hits the tee straight on its center of mass, and pushes it on. Hard contacts have a closed
/// form: one momentum, then one body. MuJoCo's give way: the differential equation of SoftPush.
std::optional<ExactMotion> hit(const PhysicsOfKind& physics) {
  const Physics& p = physics.numbers;
  constexpr double kSpeed = 0.5;     // [m/s] of the pusher
  constexpr double kOverlap = 1e-9;  // [m] so that they touch
  ExactMotion motion = {{}, {0.0F, 0.6F}, 1, {}};
  WorldState& start = motion.start;
  start.pusher_position.y() = -(p.stem_offset + p.stem_half_length + p.pusher_radius) + kOverlap;
  start.pusher_velocity.y() = kSpeed;
  motion.end = motion.start;
  if (physics.soft_contacts) {
    const SoftPush bodies = {physics, motion.action[1]};
    const auto end = integrated<4>({0.0, 0.0, 0.0, kSpeed}, motion.duration(), [&](const auto& x) {
      const auto [of_tee, of_pusher] = bodies.accelerations(kOverlap + x[1] - x[0], x[2], x[3]);
      return std::array<double, 4>{x[2], x[3], of_tee, of_pusher};
    });
    motion.end.tee_position.y() += end[0];
    motion.end.pusher_position.y() += end[1];
    return motion;
  }
  const double mass = p.pusher_mass + p.tee_mass;
  const double damping = p.servo_gain + p.pusher_damping + p.tee_damping + physics.drag_rate * p.tee_mass;
  const Linear both = {damping / mass, (p.servo_gain * motion.action[1] - p.tee_friction[1]) / mass};
  const double travel = both.travel(p.pusher_mass * kSpeed / mass, motion.duration());
  motion.end.tee_position.y() += travel;
  motion.end.pusher_position.y() += travel;
  return motion;
}

}  // namespace

const std::vector<NamedExactMotion>& exactMotions() {
  static const std::vector<NamedExactMotion> motions = {
      {"servo", servo}, {"servo at its limit", servoAtItsLimit},
      {"slide", slide}, {"slide to rest", slideToRest},
      {"spin", spin},   {"hit", hit},
  };
  return motions;
}

}  // namespace pusht::testing
