// SPDX-License-Identifier: BSD-3-Clause
// The tee alone on its table, and its mass and moment by pushes.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

#include "experiments.hpp"
#include "force_sensor.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/physics.hpp"
#include "slide_law.hpp"
#include "tee_fit.hpp"

namespace sim2sim {
namespace {

using pusht::WorldState;

/// Friction of the table, per mass of the tee.
struct TableFriction {
  double damping;    ///< [1/s]
  double friction;   ///< [m/s^2] Coulomb
  double smoothing;  ///< [m/s] 0: friction is sharp

  double frictionAt(double speed) const { return smoothing > 0.0 ? friction * std::tanh(speed / smoothing) : friction; }
};

/// [s] The tee's mass over the servo's gain: a straight push of which the pusher is the force sensor. The tee's
/// momentum takes it, and the frictions that slides have shown.
double massOverGain(Bench& bench, const Measurements& found, const TableFriction& law) {
  constexpr double kCommand = 0.6;  // [m/s]
  const ForceSensor sensor(found);
  WorldState start;
  start.tee_position = bench.shift() - Eigen::Vector2d(0.0, 0.1);
  const double reach =
      found.need(Property::kStemEnd) - found.need(Property::kOriginY) + found.need(Property::kPusherRadius);
  start.pusher_position = start.tee_position + Eigen::Vector2d(found.need(Property::kOriginX), -reach);
  const Eigen::Vector2d command(0.0, kCommand);
  const auto states = bench.run(start, std::vector<Eigen::Vector2d>(3, command));
  double impulse = 0.0;  // [m] over the gain
  double taken = 0.0;    // [m/s] per mass
  // The first step, from rest, shows the momentum; the others, which slide all the time, the frictions.
  const double friction = law.frictionAt(kCommand);  // [m/s^2]
  const std::size_t first = law.damping * kCommand + friction > 1.0 ? 1 : 0;
  for (std::size_t i = first; i + 1 < states.size(); ++i) {
    impulse += sensor.impulse(states[i], states[i + 1], command).y();
    taken += (states[i + 1].tee_velocity - states[i].tee_velocity).y() +
             law.damping * (states[i + 1].tee_position - states[i].tee_position).y() + friction * pusht::kControlStep;
  }
  if (taken < 0.1) {
    throw std::runtime_error("the push does not move the tee");
  }
  return impulse / taken;
}

/// [s m^2] The tee's moment of inertia about its center of mass, over the servo's gain: a push beside that center, of
/// which the pusher is the force sensor. The force goes through the pusher's center, as without friction.
/// `yaw_drag` [1/s]: yaw damping over moment, which free motions have shown.
double momentOverGain(Bench& bench, const Measurements& found, double center_of_mass, double yaw_drag) {
  constexpr int kSteps = 5;
  const ForceSensor sensor(found);
  WorldState start;
  start.tee_position = bench.shift();
  start.pusher_position = start.tee_position + Eigen::Vector2d(0.035, 0.04);  // behind the bar
  const Eigen::Vector2d command(0.0, -0.2);
  const auto states = bench.run(start, std::vector<Eigen::Vector2d>(kSteps, command));
  const auto arm = [&](const WorldState& state) -> Eigen::Vector2d {
    const Eigen::Vector2d down(std::sin(state.tee_yaw), -std::cos(state.tee_yaw));
    return state.pusher_position - (state.tee_position + center_of_mass * down);
  };
  double torque = 0.0;  // [m^2] over the gain, times time
  double taken = 0.0;   // [rad/s]
  for (std::size_t i = 0; i + 1 < states.size(); ++i) {
    const Eigen::Vector2d impulse = sensor.impulse(states[i], states[i + 1], command);
    const Eigen::Vector2d middle = 0.5 * (arm(states[i]) + arm(states[i + 1]));
    torque += middle.x() * impulse.y() - middle.y() * impulse.x();
    taken += states[i + 1].tee_yaw_rate - states[i].tee_yaw_rate +
             yaw_drag * pusht::wrapAngle(states[i + 1].tee_yaw - states[i].tee_yaw);
  }
  constexpr double kLeast = 0.1;  // [rad/s]
  if (std::abs(taken) < kLeast) {
    throw std::runtime_error("the push does not turn the tee");
  }
  return torque / taken;
}

/// [m^2] The tee's moment of inertia about its center of mass, over its mass: a push on the bar's back beside that
/// center, of which the tee's own momentum is the force sensor. `damping` and `yaw_drag` [1/s] are of a free tee.
double momentOverMass(Bench& bench, const Measurements& found, double center_of_mass, double yaw_drag, double damping) {
  constexpr int kSteps = 3;
  WorldState start;
  start.tee_position = bench.shift();
  const double touch = found.need(Property::kBarHalfWidth) + found.need(Property::kOriginY);
  start.pusher_position = start.tee_position + Eigen::Vector2d(0.035, touch + found.need(Property::kPusherRadius));
  const auto states = bench.run(start, std::vector<Eigen::Vector2d>(kSteps, {0.0, -0.2}));
  const auto center = [&](const WorldState& state) { return pusht::atPointOfTee(state, center_of_mass); };
  const auto arm = [&](const WorldState& state) -> Eigen::Vector2d {
    const Eigen::Vector2d back(-std::sin(state.tee_yaw), std::cos(state.tee_yaw));
    const Eigen::Vector2d contact = state.pusher_position - found.need(Property::kPusherRadius) * back;
    return contact - center(state).tee_position;
  };
  double torque = 0.0;  // [m^2/s] per mass, times time
  double taken = 0.0;   // [rad/s]
  for (std::size_t i = 0; i + 1 < states.size(); ++i) {
    const WorldState from = center(states[i]);
    const WorldState to = center(states[i + 1]);
    const Eigen::Vector2d impulse =
        to.tee_velocity - from.tee_velocity + damping * (to.tee_position - from.tee_position);
    const Eigen::Vector2d middle = 0.5 * (arm(states[i]) + arm(states[i + 1]));
    torque += middle.x() * impulse.y() - middle.y() * impulse.x();
    taken += to.tee_yaw_rate - from.tee_yaw_rate + yaw_drag * pusht::wrapAngle(to.tee_yaw - from.tee_yaw);
  }
  constexpr double kLeast = 0.1;  // [rad/s]
  if (std::abs(taken) < kLeast) {
    throw std::runtime_error("the push does not turn the tee");
  }
  return torque / taken;
}

/// Whether a tee that is thrown goes on, and so has a mass.
bool hasInertia(Bench& bench) {
  constexpr double kSpeed = 2.0;  // [m/s]
  constexpr double kLeast = 0.1;  // [-] of the way at that speed; the task's tee goes 0.17 of it
  WorldState start;
  start.tee_position = bench.shift();
  start.tee_velocity = {0.0, kSpeed};
  start.pusher_position = {0.3 - bench.narrower(), 0.0};
  const WorldState end = bench.run(start, {{0.0, 0.0}}).back();
  return (end.tee_position - start.tee_position).y() > kLeast * kSpeed * pusht::kControlStep;
}

/// [s] Mass of the task's tee over its servo's gain.
double massOfTask(const Bench& bench) { return bench.physics().tee_mass / bench.physics().servo_gain; }

/// Whether the pusher does not feel a tee of this mass over the servo's gain [s], though the tee has a mass.
bool doesNotYield(Bench& bench, double mass) {
  constexpr double kFelt = 1e-3;  // [-] of the task's
  return std::abs(mass) < kFelt * massOfTask(bench) && hasInertia(bench);
}

/// Forces are known in units of the gain. Of one without limit only the tee's own are left, in units of its mass, which
/// is taken to be the task's. Returns that [s].
double withdrawServo(const Bench& bench, Measurements& found) {
  const char* const reason = "the pusher does not yield, so it shows no force";
  for (const Property property :
       {Property::kServoLimit, Property::kPusherDamping, Property::kPusherMass, Property::kTeeMass}) {
    found.withdraw(property, reason);
  }
  found.set(Property::kServoGain, std::numeric_limits<double>::infinity());
  return massOfTask(bench);
}

/// The tee's mass over the servo's gain [s], by a push. Where no push shows it, it is taken to be the task's.
double massByPush(Bench& bench, Measurements& found, const TableFriction& law) {
  if (!bench.commandsVelocities()) {
    found.fail(Property::kTeeMass, "actions of the task are positions, which show no force");
    return massOfTask(bench);
  }
  const double mass = massOverGain(bench, found, law);
  found.set(Property::kTeeMass, mass);
  return doesNotYield(bench, mass) ? withdrawServo(bench, found) : mass;
}

constexpr double kNone = 0.3;    // [m/s^2] and [1/s] below which a force is none: a fortieth of the task's
constexpr double kSigmas = 3.0;  // of what a fit found

/// Friction along an axis by slides; where these do not tell, or friction is smooth, by the fit.
TableFriction tableFriction(const std::optional<SlideLaw>& slide, const TeeFit& fit, double friction) {
  const bool is_smooth = fit.form.smooth_friction;
  return slide && !is_smooth ? TableFriction{slide->damping, slide->friction, 0.0}
                             : TableFriction{fit.numbers.damping, friction, is_smooth ? fit.numbers.smoothing : 0.0};
}

/// [m] What slides along the axes and askew leave of their distance; none if there are too few of them.
std::optional<double> leftBySlides(const SlideLaws& slides) {
  double most = 0.0;
  for (const std::optional<SlideLaw>& slide : slides) {
    if (!slide) {
      return std::nullopt;
    }
    most = std::max(most, pusht::kControlStep * slide->rest);
  }
  return most;
}

/// Whether friction has one limit in every direction, where slides show that it is sharp. Tees that stop too early, or
/// whose friction is smooth, leave that to a fit.
std::optional<bool> isDisc(const SlideLaws& slides) {
  constexpr double kBetweenDiscAndBox = 1.2;  // [-]
  constexpr double kSharp = 2e-5;             // [m]
  return leftBySlides(slides).value_or(1.0) < kSharp
             ? std::optional(shapeOf(slides).value_or(std::sqrt(2.0)) < kBetweenDiscAndBox)
             : std::nullopt;
}

/// How well the laws explain a free tee, by slides if they tell, and whether its friction is smooth.
void setLaw(const SlideLaws& slides, const TeeFit& fit, Measurements& found) {
  const bool is_smooth = fit.form.smooth_friction;
  found.set(Property::kTeeLaw, isDisc(slides) ? *leftBySlides(slides) : fit.residual);
  found.set(Property::kFrictionSmoothing, is_smooth ? fit.numbers.smoothing : 0.0,
            is_smooth ? kSigmas * fit.errors[9] : 0.0);
}

void setCoulombForm(const SlideLaws& slides, const TeeFit& fit, bool has_friction, Measurements& found) {
  if (!has_friction) {
    found.fail(Property::kFrictionShape, "there is no Coulomb friction");
    found.fail(Property::kFrictionPoint, "there is no Coulomb friction");
    return;
  }
  found.set(Property::kFrictionShape, shapeOf(slides).value_or(fit.form.disc_friction ? 1.0 : std::sqrt(2.0)));
  found.set(Property::kFrictionPoint, fit.numbers.friction_point, kSigmas * fit.errors[8]);
}

/// Moment, damping and friction of the yaw, for a tee of this mass over the gain [s]. If nothing but damping and
/// friction at the center of mass acts on a tee, its motions show them over its moment alone; then a push shows that.
void setTurning(Bench& bench, const TeeFit& fit, double mass, Measurements& found) {
  const TeeNumbers& numbers = fit.numbers;
  constexpr double kRounding = 1e-6;  // [m^2/s^2] of a task that has no friction
  const bool has_friction = bench.physics().tee_yaw_friction > 0.0 || numbers.yaw_friction > kRounding;
  const double yaw_friction = has_friction ? numbers.yaw_friction : 0.0;
  constexpr double kUnknown = 0.3;  // [-] relative error
  if (kSigmas * fit.errors[1] < kUnknown * numbers.moment) {
    found.set(Property::kTeeMoment, numbers.moment * mass, kSigmas * fit.errors[1] * mass);
    found.set(Property::kTeeYawDamping, numbers.yaw_damping * mass, kSigmas * fit.errors[3] * mass);
    found.set(Property::kTeeYawFriction, yaw_friction * mass, kSigmas * fit.errors[6] * mass);
    return;
  }
  const double yaw_drag = numbers.yaw_damping / numbers.moment;  // [1/s]
  const double moment = bench.commandsVelocities()
                            ? momentOverGain(bench, found, numbers.center_of_mass, yaw_drag)
                            : mass * momentOverMass(bench, found, numbers.center_of_mass, yaw_drag, numbers.damping);
  constexpr double kOfPush = 0.25;  // [-] relative error: with friction the force passes beside the pusher's center
  const auto set = [&](Property property, double value) { found.set(property, value, kOfPush * value); };
  set(Property::kTeeMoment, moment);
  set(Property::kTeeYawDamping, yaw_drag * moment);
  set(Property::kTeeYawFriction, yaw_friction / numbers.moment * moment);
}

void freeTee(Bench& bench, Measurements& found) {
  const SlideLaws slides = slideLaws(bench);
  TeeNumbers begin = TeeNumbers::of(bench.physics());
  if (slides[0] && slides[1]) {
    begin.damping = 0.5 * (slides[0]->damping + slides[1]->damping);
    begin.friction_x = std::max(0.0, slides[0]->friction);
    begin.friction_y = std::max(0.0, slides[1]->friction);
  }
  const TeeFit fit = fitFreeTee(bench, begin, isDisc(slides));
  found.set(Property::kCenterOfMass, fit.numbers.center_of_mass, kSigmas * fit.errors[0]);

  const TableFriction along_x = tableFriction(slides[0], fit, fit.numbers.friction_x);
  const TableFriction along_y = tableFriction(slides[1], fit, fit.numbers.friction_y);
  setLaw(slides, fit, found);
  const double damping = 0.5 * (along_x.damping + along_y.damping);
  const double mass = massByPush(bench, found, along_y);
  found.set(Property::kTeeDamping, damping * mass);
  const bool has_friction = bench.physics().tee_friction[0] > 0.0;
  const auto friction_of = [&](const TableFriction& along) {  // of a task that has none, rounding is none
    return has_friction || along.friction > kNone ? along.friction * mass : 0.0;
  };
  found.set(Property::kTeeFrictionX, friction_of(along_x));
  found.set(Property::kTeeFrictionY, friction_of(along_y));
  setCoulombForm(slides, fit, 0.5 * (along_x.friction + along_y.friction) > kNone, found);
  if (damping > kNone) {
    found.set(Property::kDampingPoint, fit.numbers.damping_point, kSigmas * fit.errors[7]);
  } else {
    found.fail(Property::kDampingPoint, "there is no damping");
  }
  setTurning(bench, fit, mass, found);
}

}  // namespace

std::vector<Experiment> teeExperiments() {
  return {{"free tee",
           {Property::kTeeMass, Property::kCenterOfMass, Property::kTeeMoment, Property::kTeeDamping,
            Property::kTeeYawDamping, Property::kTeeFrictionX, Property::kTeeFrictionY, Property::kTeeYawFriction,
            Property::kFrictionShape, Property::kDampingPoint, Property::kFrictionPoint, Property::kFrictionSmoothing,
            Property::kTeeLaw},
           freeTee}};
}

}  // namespace sim2sim
