// SPDX-License-Identifier: BSD-3-Clause
#include "free_pusher.hpp"

#include <cmath>
#include <vector>

namespace sim2sim::free_pusher {

pusht::WorldState startFor(const Bench& bench, const Eigen::Vector2d& side) {
  constexpr double kFromMiddle = 0.28;  // [m]
  constexpr double kLane = -0.24;       // [m] of the other coordinate; the tee is in the opposite corner
  pusht::WorldState start;
  start.tee_position = {0.2, 0.25};
  start.tee_yaw = 0.5;  // what is in the tee's axes is not in the table's
  const bool along_x = std::abs(side.x()) > std::abs(side.y());
  const double place = kFromMiddle * (along_x ? side.x() : side.y()) / side.norm();
  start.pusher_position = along_x ? Eigen::Vector2d(place, kLane) : Eigen::Vector2d(kLane, place);
  start.pusher_position += bench.shift();
  return start;
}

double travel(Bench& bench, const Eigen::Vector2d& axis, double velocity, double command) {
  const bool backwards = command != 0.0 ? command < 0.0 : velocity < 0.0;
  pusht::WorldState start = startFor(bench, backwards ? axis : Eigen::Vector2d(-axis));
  start.pusher_velocity = velocity * axis;
  const auto states = bench.run(start, std::vector<Eigen::Vector2d>(kTravelSteps, command * axis));
  return (states.back().pusher_position - states.front().pusher_position).dot(axis);
}

double timeConstant(Bench& bench, const Eigen::Vector2d& axis) {
  constexpr double kVelocity = 0.1;  // [m/s] within a servo limit of a fifteenth of the task's
  return travel(bench, axis, kVelocity, 0.0) / kVelocity;
}

}  // namespace sim2sim::free_pusher
