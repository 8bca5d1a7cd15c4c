// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_audit/bench.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"

namespace sim2sim {
namespace {

/// [m] Motion that tells a push from rounding, also in single precision.
constexpr double kLeastMotion = 3e-7;

Eigen::Vector2d shiftOf(std::uint64_t seed) {
  pusht::NumpyGenerator generator(seed, "audit");
  const double x = generator.uniform(-Bench::kShift, Bench::kShift);
  return {x, generator.uniform(-Bench::kShift, Bench::kShift)};
}

/// Least distance of `approach` at which is_touching() fails, by bisection; none if it fails where bodies overlap.
template <class IsTouching>
std::optional<double> edgeOf(const Approach& approach, const IsTouching& is_touching) {
  constexpr double kPrecision = 1e-7;  // [m]
  double touching = approach.overlapping;
  double free = approach.apart;
  if (!is_touching(touching)) {
    return std::nullopt;
  }
  while (std::abs(free - touching) > kPrecision) {
    const double middle = 0.5 * (free + touching);
    (is_touching(middle) ? touching : free) = middle;
  }
  return free;
}

}  // namespace

Bench::Bench(pusht::Simulator& world, WorldFactory make_second, std::uint64_t seed)
    : world_(world), make_second_(std::move(make_second)), seed_(seed), shift_(shiftOf(seed)) {}

pusht::WorldState Bench::reset(const pusht::WorldState& state) {
  world_.reset(state);
  return reported();
}

pusht::WorldState Bench::reported() {
  pusht::WorldState state = world_.state();
  pusher_ = state.pusher_position;
  return state;
}

pusht::WorldState Bench::step(const Eigen::Vector2d& command) {
  const pusht::Action action = {static_cast<float>(command.x()), static_cast<float>(command.y())};
  world_.step(commandsVelocities() ? action : pusht::actionFor(command, pusher_, task()));
  return reported();
}

std::vector<pusht::WorldState> Bench::run(const pusht::WorldState& start,
                                          const std::vector<Eigen::Vector2d>& commands) {
  std::vector<pusht::WorldState> states = {reset(start)};
  for (const Eigen::Vector2d& command : commands) {
    states.push_back(step(command));
  }
  return states;
}

bool Bench::isPushedApart(const pusht::WorldState& state) {
  pusht::WorldState before;
  try {
    before = reset(state);
  } catch (const pusht::SimulationFault&) {
    return true;
  }
  return distanceBetween(before, step({0.0, 0.0})) > kLeastMotion;
}

Bench::Way Bench::slowWay(const pusht::WorldState& start, const Eigen::Vector2d& direction) {
  // [m/s] So slow that what the pusher goes in a control step is less than what counts of a length, and so fast that
  // rounding in single precision is a small share of it.
  constexpr double kSlow = 1e-3;
  const pusht::WorldState before = reset(start);
  const pusht::WorldState after = step(kSlow * direction);
  const double turned = std::abs(pusht::wrapAngle(after.tee_yaw - before.tee_yaw));
  return {after.pusher_position - before.pusher_position,
          std::max((after.tee_position - before.tee_position).norm(), pusht::kStemOffset * turned)};
}

bool Bench::isHeld(const pusht::WorldState& state, const Eigen::Vector2d& direction, const Way& free) {
  constexpr double kShare = 0.05;  // [-] of the free way
  const Way way = slowWay(state, direction);
  return (way.of_pusher - free.of_pusher).norm() > kShare * free.of_pusher.norm() ||
         way.of_tee > free.of_tee + kLeastMotion;
}

pusht::WorldState Approach::at(double distance) const {
  pusht::WorldState state = scene;
  state.pusher_position = center + distance * outward;
  return state;
}

std::optional<double> pushedDistance(Bench& bench, const Approach& approach) {
  const auto is_pushed_at = [&](double distance) { return bench.isPushedApart(approach.at(distance)); };
  bench.reset(approach.at(approach.apart));  // a world that refuses this start refuses for another reason
  if (is_pushed_at(approach.apart)) {
    throw std::runtime_error("the world moves where nothing touches");
  }
  return edgeOf(approach, is_pushed_at);
}

std::optional<double> heldDistance(Bench& bench, const Approach& approach) {
  const double sign = approach.overlapping < approach.apart ? -1.0 : 1.0;  // of the way to the surface
  const Eigen::Vector2d inward = sign * approach.outward;
  const Bench::Way free = bench.slowWay(approach.at(approach.apart), inward);
  const auto edge =
      edgeOf(approach, [&](double distance) { return bench.isHeld(approach.at(distance), inward, free); });
  return edge ? std::optional(*edge + sign * free.of_pusher.norm()) : std::nullopt;  // where it was held in the end
}

std::optional<double> touchDistance(Bench& bench, const Approach& approach) {
  const std::optional<double> pushed = pushedDistance(bench, approach);
  return pushed ? pushed : heldDistance(bench, approach);
}

double distanceBetween(const pusht::WorldState& a, const pusht::WorldState& b) {
  return std::max({(a.pusher_position - b.pusher_position).norm(), (a.tee_position - b.tee_position).norm(),
                   pusht::kStemOffset * std::abs(pusht::wrapAngle(a.tee_yaw - b.tee_yaw)),
                   pusht::kControlStep * (a.pusher_velocity - b.pusher_velocity).norm(),
                   pusht::kControlStep * (a.tee_velocity - b.tee_velocity).norm(),
                   pusht::kControlStep * pusht::kStemOffset * std::abs(a.tee_yaw_rate - b.tee_yaw_rate)});
}

}  // namespace sim2sim
