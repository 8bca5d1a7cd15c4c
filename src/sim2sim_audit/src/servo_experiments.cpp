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
/// pusher goes farther than in proportion.
double missingVelocityAtLimit(Bench& bench, double time_constant) {
  constexpr double kSlow = 0.25;
  constexpr double kFast = 4.0;  // a command and a velocity of the task miss each other by at most 2 m/s
  return kneeOf(kSlow, kFast, [&](double velocity) {
    const double linear = time_constant * velocity;
    return std::abs(free_pusher::travel(bench, kAxes[0], velocity, 0.0) - linear) <= kNonlinear;
  });
}

/// [-] What the servo makes of a command of 1 m/s: found by how large a command brings it to its limit when the pusher
/// moves against it. None if that is out of reach.
std::optional<double> scaleOfCommand(Bench& bench, double at_limit, double time_constant, double speed_per_command) {
  constexpr double kCommand = 0.5;  // [m/s] that would be at the limit of a scale of 1
  if (!std::isfinite(at_limit) || at_limit <= kCommand) {
    return std::nullopt;
  }
  const double velocity = -(at_limit - kCommand);
  const double duration = free_pusher::kTravelSteps * pusht::kControlStep;
  const double knee = kneeOf(0.0, pusht::kActionLimit, [&](double command) {
    const double linear = speed_per_command * command * (duration - time_constant) + time_constant * velocity;
    return std::abs(free_pusher::travel(bench, kAxes[0], velocity, command) - linear) <= kNonlinear;
  });
  if (!std::isfinite(knee)) {
    return std::nullopt;
  }
  return kCommand / knee;
}

/// Gain, damping, limit and mass. With a scale of the command that is known from the limit, the steady error is the
/// damping's. Without a limit the two cannot be told apart, and the scale is taken to be 1.
void servo(Bench& bench, Measurements& found) {
  const double time_constant = free_pusher::timeConstant(bench, kAxes[0]);  // [s]
  const double speed_per_command = found.need(Property::kActionScaleX);     // [-]
  const double at_limit = missingVelocityAtLimit(bench, time_constant);
  const std::optional<double> scale = scaleOfCommand(bench, at_limit, time_constant, speed_per_command);
  const double gain_share = speed_per_command / scale.value_or(1.0);  // [-] gain / (gain + damping)
  const double anisotropy = found.need(Property::kActionScaleY) / speed_per_command;
  found.set(Property::kServoGain, 1.0);
  found.set(Property::kServoLimit, at_limit);
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

/// Distance that a coasting pusher goes, over its speed, less that with a speed that falls steadily as it falls in a
/// control step. That is below 0 where bodies move with the velocities of a substep's end, above 0 with those of its
/// begin, and about half a substep, whatever mass and servo are.
void moveOrder(Bench& bench, Measurements& found) {
  constexpr double kVelocity = 0.1;  // [m/s]
  pusht::WorldState start = free_pusher::startFor(bench, -kAxes[0]);
  start.pusher_velocity = kVelocity * kAxes[0];
  const double left = bench.run(start, {{0.0, 0.0}}).back().pusher_velocity.dot(kAxes[0]) / kVelocity;
  constexpr double kLeast = 1e-9;
  if (!(left > kLeast && left < 1.0)) {
    throw std::runtime_error("the pusher does not coast");
  }
  const double steady = -found.need(Property::kControlStep) / std::log(left);  // [s]
  found.set(Property::kMoveOrder, free_pusher::timeConstant(bench, kAxes[0]) - steady);
}

}  // namespace

std::vector<Experiment> servoExperiments() {
  return {
      {"servo", {Property::kServoGain, Property::kServoLimit, Property::kPusherDamping, Property::kPusherMass}, servo},
      {"overshoot", {Property::kOvershoot}, overshoot},
      {"order of moves", {Property::kMoveOrder}, moveOrder}};
}

}  // namespace sim2sim
