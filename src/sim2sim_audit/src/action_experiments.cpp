// SPDX-License-Identifier: BSD-3-Clause
// What a command does, when, and how far: the pusher alone, in free space.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "experiments.hpp"
#include "free_pusher.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/physics.hpp"

namespace sim2sim {
namespace {

using free_pusher::kAxes;
using free_pusher::kCommand;
using pusht::kControlStep;

/// Distance of the last control step of a constant command, and the velocity reported at its end.
struct Response {
  Eigen::Vector2d displacement;  ///< [m]
  Eigen::Vector2d velocity;      ///< [m/s]
  Eigen::Vector2d whole;         ///< [m] from the start, over kSteps
};
constexpr int kSteps = 5;

Response responseFrom(Bench& bench, const pusht::WorldState& start, const Eigen::Vector2d& command) {
  const auto states = bench.run(start, std::vector<Eigen::Vector2d>(kSteps, command));
  return {states[kSteps].pusher_position - states[kSteps - 1].pusher_position, states[kSteps].pusher_velocity,
          states[kSteps].pusher_position - states[0].pusher_position};
}

/// Response from a place around which there is room in every direction: the world may have its own idea of axes.
Response responseTo(Bench& bench, const Eigen::Vector2d& command) {
  pusht::WorldState start = free_pusher::startFor(bench, command);
  start.pusher_position = bench.shift() + Eigen::Vector2d(-0.1, -0.1);
  return responseFrom(bench, start, command);
}

/// Length of a control step, unit of the pusher's velocity, and share of a step for which the command holds. Distance
/// in a step over command and reported velocity over command tell. Where they disagree, the one that is near the
/// command is believed; where neither is, the command does not hold. A velocity counts as far as it has the direction
/// of the motion.
void stepAndVelocity(Bench& bench, Measurements& found) {
  double by_distance = 0.0;  // [-]
  double by_velocity = 0.0;
  for (const Eigen::Vector2d& axis : kAxes) {
    const Response response = responseTo(bench, kCommand * axis);
    by_distance += 0.5 * response.displacement.norm() / (kCommand * kControlStep);
    by_velocity += 0.5 * response.velocity.dot(response.displacement.normalized()) / kCommand;
  }
  constexpr double kDisagreement = 0.05;  // [-]
  constexpr double kNear = 0.8;           // [-] of the command
  const pusht::Physics task;
  const double steady = task.servo_gain / (task.servo_gain + task.pusher_damping);
  const double ratio = by_velocity / by_distance;
  const bool velocity_is_nearer = std::abs(by_velocity - steady) < std::abs(by_distance - steady);
  const bool holds = std::max(by_distance, by_velocity) > kNear || std::abs(ratio - 1.0) < kDisagreement;
  found.set(Property::kControlStep, holds && velocity_is_nearer ? kControlStep / ratio : kControlStep);
  found.set(Property::kPusherVelocityFactor, holds && !velocity_is_nearer ? ratio : 1.0);
  if (!holds) {
    found.set(Property::kHold, by_distance);
  }
}

/// A command is a velocity: a pusher that has taken one up goes on as fast. One so small that a pusher which it
/// accelerates stays on the table.
void steadiness(Bench& bench, Measurements& found) {
  constexpr double kSmall = 0.02;  // [m/s]
  constexpr int kLong = 7;         // control steps
  const auto states =
      bench.run(free_pusher::startFor(bench, -kAxes[0]), std::vector<Eigen::Vector2d>(kLong, kSmall * kAxes[0]));
  const auto step = [&](int i) { return (states[i].pusher_position - states[i - 1].pusher_position).norm(); };
  const double last = step(kLong);
  found.set(Property::kSpeedGain, last > 0.0 ? (last - step(kLong - 1)) / last : 0.0);
}

/// A pusher and a tee at rest stay where they are.
void rest(Bench& bench, Measurements& found) {
  constexpr int kRestSteps = 3;
  const auto states =
      bench.run(free_pusher::startFor(bench, kAxes[0]), std::vector<Eigen::Vector2d>(kRestSteps, {0.0, 0.0}));
  found.set(Property::kRestMotion, distanceBetween(states.front(), states.back()));
}

/// A small command moves the pusher in proportion, along either axis.
void smallCommand(Bench& bench, Measurements& found) {
  constexpr double kSmall = 0.02;  // [m/s]
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& axis : kAxes) {
    const double small = responseTo(bench, kSmall * axis).displacement.norm();
    const double usual = responseTo(bench, kCommand * axis).displacement.norm();
    least = std::min(least, small / usual * kCommand / kSmall);
  }
  found.set(Property::kSmallCommand, least);
}

/// Response of the pusher to commands along x and y: which axis, which sign, how far.
void axes(Bench& bench, Measurements& found) {
  Eigen::Matrix2d response;
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d command = kCommand * kAxes[static_cast<std::size_t>(axis)];
    response.col(axis) = (responseTo(bench, command).displacement - responseTo(bench, -command).displacement) /
                         (2.0 * kCommand * found.need(Property::kControlStep));
  }
  found.set(Property::kAxesMirror, response.determinant() < 0.0 ? -1.0 : 1.0);
  const double hand = response.determinant() < 0.0 ? -1.0 : 1.0;
  const double of_x = std::atan2(response(1, 0), response(0, 0));
  const double of_y = std::atan2(-hand * response(0, 1), hand * response(1, 1));
  found.set(Property::kAxesTurn, std::abs(of_x) > std::abs(of_y) ? of_x : of_y);
  found.set(Property::kActionScaleX, response.col(0).norm());
  found.set(Property::kActionScaleY, response.col(1).norm());
}

/// Largest command along an axis that the pusher still follows, over axes, diagonals and signs: each axis has its own
/// limit.
void limitOfActions(Bench& bench, Measurements& found) {
  double least = pusht::kActionLimit;
  for (const Eigen::Vector2d& direction :
       {Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(0.0, 1.0), Eigen::Vector2d(1.0, 1.0), Eigen::Vector2d(1.0, -1.0)}) {
    for (const double sign : {1.0, -1.0}) {
      pusht::WorldState start = free_pusher::startFor(bench, -sign * direction);
      if (direction.x() * direction.y() != 0.0) {
        start.tee_position = 0.2 * Eigen::Vector2d(direction.y(), -direction.x());
        start.pusher_position = bench.shift() - 0.25 * sign * direction;
      }
      const double small = responseFrom(bench, start, sign * kCommand * direction).displacement.norm();
      const double full = responseFrom(bench, start, sign * direction).displacement.norm();
      least = std::min(least, kCommand * full / small);
    }
  }
  found.set(Property::kActionLimit, least);
}

/// How far a response to a command is behind one without a lag, less the lag of a pusher that coasts: what is left is
/// no property of a body. And how long one command lasts, from all that it moves the pusher.
void delayAndHold(Bench& bench, Measurements& found) {
  const double step = found.need(Property::kControlStep);
  double latest = 0.0;    // [s]
  double per_step = 0.0;  // [m]
  for (const Eigen::Vector2d& axis : kAxes) {
    const Response response = responseTo(bench, kCommand * axis);
    per_step = response.displacement.norm();
    const double lag = step * (kSteps - response.whole.norm() / per_step);
    const double coasting = free_pusher::timeConstant(bench, axis) * found.need(Property::kPusherVelocityFactor);
    const double delay = lag - coasting - step * found.need(Property::kStaleSteps);
    latest = std::abs(delay) > std::abs(latest) ? delay : latest;
  }
  found.set(Property::kDelay, latest);

  const Eigen::Vector2d command = kCommand * kAxes[1];
  std::vector<Eigen::Vector2d> pulse(kSteps + 1, Eigen::Vector2d::Zero());
  pulse.front() = command;
  const auto states = bench.run(free_pusher::startFor(bench, -command), pulse);
  if (!found[Property::kHold].value) {
    found.set(Property::kHold, (states.back().pusher_position - states.front().pusher_position).norm() / per_step);
  }
}

}  // namespace

std::vector<Experiment> actionExperiments() {
  return {
      {"control step", {Property::kControlStep, Property::kPusherVelocityFactor, Property::kHold}, stepAndVelocity},
      {"axes", {Property::kAxesTurn, Property::kAxesMirror, Property::kActionScaleX, Property::kActionScaleY}, axes},
      {"steadiness", {Property::kSpeedGain}, steadiness},
      {"rest", {Property::kRestMotion}, rest},
      {"small command", {Property::kSmallCommand}, smallCommand},
      {"limit of actions", {Property::kActionLimit}, limitOfActions},
      {"delay", {Property::kDelay, Property::kHold}, delayAndHold}};
}

}  // namespace sim2sim
