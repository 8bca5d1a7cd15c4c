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
constexpr double kMotion = 3e-7;

Eigen::Vector2d shiftOf(std::uint64_t seed) {
  pusht::NumpyGenerator generator(seed, "audit");
  const double x = generator.uniform(-Bench::kShift, Bench::kShift);
  return {x, generator.uniform(-Bench::kShift, Bench::kShift)};
}

}  // namespace

Bench::Bench(pusht::Simulator& world, WorldFactory make_second, std::uint64_t seed)
    : world_(world), make_second_(std::move(make_second)), seed_(seed), shift_(shiftOf(seed)) {}

pusht::WorldState Bench::reset(const pusht::WorldState& state) {
  world_.reset(state);
  return world_.state();
}

pusht::WorldState Bench::step(const Eigen::Vector2d& command) {
  world_.step({static_cast<float>(command.x()), static_cast<float>(command.y())});
  return world_.state();
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
  return distanceBetween(before, step({0.0, 0.0})) > kMotion;
}

std::optional<double> touchDistance(Bench& bench, const pusht::WorldState& scene, const Eigen::Vector2d& center,
                                    const Eigen::Vector2d& outward, double overlapping, double apart) {
  constexpr double kPrecision = 1e-7;  // [m]
  const auto with_pusher_at = [&](double distance) {
    pusht::WorldState state = scene;
    state.pusher_position = center + distance * outward;
    return state;
  };
  const auto is_pushed_at = [&](double distance) { return bench.isPushedApart(with_pusher_at(distance)); };
  bench.reset(with_pusher_at(apart));  // a world that refuses this start refuses for another reason
  if (is_pushed_at(apart)) {
    throw std::runtime_error("the world moves where nothing touches");
  }
  if (!is_pushed_at(overlapping)) {
    return std::nullopt;
  }
  while (std::abs(apart - overlapping) > kPrecision) {
    const double middle = 0.5 * (apart + overlapping);
    (is_pushed_at(middle) ? overlapping : apart) = middle;
  }
  return apart;
}

double distanceBetween(const pusht::WorldState& a, const pusht::WorldState& b) {
  return std::max({(a.pusher_position - b.pusher_position).norm(), (a.tee_position - b.tee_position).norm(),
                   pusht::kStemOffset * std::abs(pusht::wrapAngle(a.tee_yaw - b.tee_yaw)),
                   pusht::kControlStep * (a.pusher_velocity - b.pusher_velocity).norm(),
                   pusht::kControlStep * (a.tee_velocity - b.tee_velocity).norm(),
                   pusht::kControlStep * pusht::kStemOffset * std::abs(a.tee_yaw_rate - b.tee_yaw_rate)});
}

}  // namespace sim2sim
