// SPDX-License-Identifier: BSD-3-Clause
// The pusher's servo. A free pusher shows its forces in units of each other alone: here in units of the servo's gain.
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "experiments.hpp"
#include "free_pusher.hpp"
#include "pusht_task/constants.hpp"

namespace sim2sim {
namespace {

using free_pusher::kAxes;

/// [m] Deviation from a linear response that shows a limit.
constexpr double kNonlinear = 1e-5;

/// Least number above `linear` up to `most` for which is_linear() fails, by bisection; infinity if it never fails.
template <class IsLinear>
double kneeOf(double linear, double most, const IsLinear& is_linear) {
  constexpr double kPrecision = 1e-4;  // of the range
  if (is_linear(most)) {
    return std::numeric_limits<double>::infinity();
  }
  const double precision = kPrecision * (most - linear);
  while (most - linear > precision) {
    const double middle = 0.5 * (linear + most);
    (is_linear(middle) ? linear : most) = middle;
  }
  return most;
}

/// [m/s] Missing velocity from which on the servo's force is at its limit: the least velocity from which a coasting
/// pusher goes farther than in proportion. None if it never goes in proportion.
std::optional<double> missingVelocityAtLimit(Bench& bench, double time_constant) {
  constexpr double kSlow = 0.25;
  constexpr double kFast = 4.0;  // a command and a velocity of the task miss each other by at most 2 m/s
  const auto is_linear = [&](double velocity) {
    const double linear = time_constant * velocity;
    return std::abs(free_pusher::travel(bench, kAxes[0], velocity, 0.0) - linear) <= kNonlinear;
  };
  return is_linear(kSlow) ? std::optional(kneeOf(kSlow, kFast, is_linear)) : std::nullopt;
}

/// [-] What the servo makes of a command of 1 m/s: found by how large a command brings it to its limit when the pusher
/// moves against it. None if that is out of reach, or if the pusher's damping were more than its servo's.
std::optional<double> scaleOfCommand(Bench& bench, double at_limit, double time_constant, double speed_per_command) {
  constexpr double kCommand = 0.5;     // [m/s] that would be at the limit of a scale of 1
  constexpr double kLeastShare = 0.5;  // [-] gain / (gain + damping)
  if (!std::isfinite(at_limit) || at_limit <= kCommand) {
    return std::nullopt;
  }
  const double velocity = -(at_limit - kCommand);
  const double duration = free_pusher::kTravelSteps * pusht::kControlStep;
  const double knee = kneeOf(0.0, pusht::kActionLimit, [&](double command) {
    const double linear = speed_per_command * command * (duration - time_constant) + time_constant * velocity;
    return std::abs(free_pusher::travel(bench, kAxes[0], velocity, command) - linear) <= kNonlinear;
  });
  const double scale = kCommand / knee;
  return std::isfinite(knee) && scale * kLeastShare <= speed_per_command ? std::optional(scale) : std::nullopt;
}

/// Gain, damping, limit and mass. With a scale of the command that is known from the limit, the steady error is the
/// damping's. Without a limit the two cannot be told apart, and the scale is taken to be 1.
void servo(Bench& bench, Measurements& found) {
  const double time_constant = free_pusher::timeConstant(bench, kAxes[0]);  // [s]
  const double speed_per_command = found.need(Property::kActionScaleX);     // [-]
  const std::optional<double> at_limit = missingVelocityAtLimit(bench, time_constant);
  const std::optional<double> scale =
      at_limit ? scaleOfCommand(bench, *at_limit, time_constant, speed_per_command) : std::nullopt;
  const double gain_share = speed_per_command / scale.value_or(1.0);  // [-] gain / (gain + damping)
  const double anisotropy = found.need(Property::kActionScaleY) / speed_per_command;
  found.set(Property::kServoGain, 1.0);
  if (at_limit) {
    found.set(Property::kServoLimit, *at_limit);
  } else {
    found.fail(Property::kServoLimit, "a pusher does not coast in proportion to its velocity");
  }
  found.set(Property::kPusherDamping, 1.0 / gain_share - 1.0);
  found.set(Property::kPusherMass, time_constant / gain_share);
  found.set(Property::kActionScaleX, scale.value_or(1.0));
  found.set(Property::kActionScaleY, scale.value_or(1.0) * anisotropy);
}

/// Highest speed on the way to a steady one, over that.
void overshoot(Bench& bench, Measurements& found) {
  const auto states = bench.run(free_pusher::startFor(bench, -kAxes[0]), std::vector<Eigen::Vector2d>(5, kAxes[0]));
  double highest = 0.0;
  for (const pusht::WorldState& state : states) {
    highest = std::max(highest, state.pusher_velocity.norm());
  }
  found.set(Property::kOvershoot, highest / states.back().pusher_velocity.norm() - 1.0);
}

/// [-] Share of its velocity that a coasting pusher keeps in a control step.
double keptShare(Bench& bench) {
  constexpr double kVelocity = 0.1;  // [m/s]
  pusht::WorldState start = free_pusher::startFor(bench, -kAxes[0]);
  start.pusher_velocity = kVelocity * kAxes[0];
  return bench.run(start, {{0.0, 0.0}}).back().pusher_velocity.dot(kAxes[0]) / kVelocity;
}

/// [s] Substep of a servo by which a pusher keeps as much of its velocity as one whose speed falls steadily with the
/// time constant `steady` [s], and coasts, over its speed, for `coasting` [s]. An implicit servo keeps the share
/// s = coasting / (coasting + h) of it in a substep h, so that h = steady * -ln(s); by bisection. 0 if there is none.
double substepOf(double coasting, double steady) {
  constexpr double kLongest = 0.1;     // [s]
  constexpr double kPrecision = 1e-7;  // [s]
  double shorter = 0.0;
  double longer = kLongest;
  while (longer - shorter > kPrecision) {
    const double middle = 0.5 * (shorter + longer);
    (middle > steady * std::log1p(middle / coasting) ? longer : shorter) = middle;
  }
  return longer < kLongest ? shorter : 0.0;
}

/// Distance that a coasting pusher goes, over its speed, less that with a speed that falls steadily as it falls in a
/// control step. That is below 0 where bodies move with the velocities of a substep's end, above 0 with those of its
/// begin, and about half a substep, whatever mass and servo are. And how late the force of an explicit servo is: it
/// moves a free pusher as an implicit one does, so that audits ask the mass which of them it is (isServoExplicit()).
void moveOrder(Bench& bench, Measurements& found) {
  const double left = keptShare(bench);
  const double coasting = free_pusher::timeConstant(bench, kAxes[0]);  // [s]
  constexpr double kLeast = 1e-9;
  if (!(left > kLeast && left < 1.0)) {
    // A pusher that stops in a substep: explicit, as the task's numbers make it stop in 10 ms, or without inertia.
    const double late = coasting < pusht::kSubstep ? pusht::kSubstep : 0.0;
    found.set(Property::kServoLag, late);
    throw std::runtime_error("the pusher does not coast");
  }
  const double steady = -found.need(Property::kControlStep) / std::log(left);  // [s]
  found.set(Property::kMoveOrder, coasting - steady);
  found.set(Property::kServoLag, coasting < steady ? substepOf(coasting, steady) : 0.0);
}

}  // namespace

std::vector<Experiment> servoExperiments() {
  return {
      {"servo", {Property::kServoGain, Property::kServoLimit, Property::kPusherDamping, Property::kPusherMass}, servo},
      {"overshoot", {Property::kOvershoot}, overshoot},
      {"order of moves", {Property::kMoveOrder, Property::kServoLag}, moveOrder}};
}

}  // namespace sim2sim
