// SPDX-License-Identifier: BSD-3-Clause
// Does a world start where it is told, and does what it reports say all?
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "experiments.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/spawn.hpp"

namespace sim2sim {
namespace {

using pusht::WorldState;

/// Starts with velocities of every sign: half of them as in an episode, half as after a hit; some where the yaw wraps.
std::vector<WorldState> startsOf(std::uint64_t seed, const pusht::Task& task) {
  constexpr int kStarts = 12;
  pusht::NumpyGenerator generator(seed, "audit starts");
  std::vector<WorldState> starts;
  for (int i = 0; i < kStarts; ++i) {
    WorldState state = pusht::spawn(seed + static_cast<std::uint64_t>(i), task);
    const double speed = i % 2 == 0 ? 0.5 : 3.0;      // [m/s]
    const double yaw_rate = i % 2 == 0 ? 3.0 : 20.0;  // [rad/s]
    for (double* velocity :
         {&state.pusher_velocity.x(), &state.pusher_velocity.y(), &state.tee_velocity.x(), &state.tee_velocity.y()}) {
      *velocity = generator.uniform(-speed, speed);
    }
    state.tee_yaw_rate = generator.uniform(-yaw_rate, yaw_rate);
    if (i % 4 == 3) {
      state.tee_yaw = pusht::wrapAngle(pusht::kPi + generator.uniform(-0.01, 0.01));
    }
    starts.push_back(state);
  }
  return starts;
}

/// Largest deviation of each field, over starts.
struct Deviation {
  double pusher_position = 0.0;
  double pusher_velocity = 0.0;
  double tee_position = 0.0;
  double tee_velocity = 0.0;
  double yaw = 0.0;
  double yaw_rate = 0.0;

  void take(const WorldState& wanted, const WorldState& found) {
    const auto grow = [](double& largest, double value) { largest = std::max(largest, value); };
    grow(pusher_position, (found.pusher_position - wanted.pusher_position).norm());
    grow(pusher_velocity, (found.pusher_velocity - wanted.pusher_velocity).norm());
    grow(tee_position, (found.tee_position - wanted.tee_position).norm());
    grow(tee_velocity, (found.tee_velocity - wanted.tee_velocity).norm());
    grow(yaw, std::abs(pusht::wrapAngle(found.tee_yaw - wanted.tee_yaw)));
    grow(yaw_rate, std::abs(found.tee_yaw_rate - wanted.tee_yaw_rate));
  }
  double largest() const {
    return std::max({pusher_position, pusher_velocity, tee_position, tee_velocity, yaw, yaw_rate});
  }
};

void startRoundTrip(Bench& bench, Measurements& found) {
  Deviation deviation;
  Deviation of_fixed_point;
  int refused = 0;
  std::string refusal;
  const std::vector<WorldState> starts = startsOf(bench.seed(), bench.task());
  for (const WorldState& start : starts) {
    try {
      const WorldState once = bench.reset(start);
      deviation.take(start, once);
      of_fixed_point.take(once, bench.reset(once));
    } catch (const pusht::SimulationFault& fault) {
      ++refused;
      refusal = fault.what();
    }
  }
  found.set(Property::kRefusedStarts, refused);
  if (refused == static_cast<int>(starts.size())) {
    throw std::runtime_error(refusal);
  }
  found.set(Property::kStartPusherPosition, deviation.pusher_position);
  found.set(Property::kStartPusherVelocity, deviation.pusher_velocity);
  found.set(Property::kStartTeePosition, deviation.tee_position);
  found.set(Property::kStartTeeVelocity, deviation.tee_velocity);
  found.set(Property::kStartYaw, deviation.yaw);
  found.set(Property::kStartYawRate, deviation.yaw_rate);
  found.set(Property::kFixedPoint, of_fixed_point.largest());
}

/// Short script of resets and commands in which the pusher pushes the tee and turns it.
struct Script {
  WorldState start;
  std::vector<Eigen::Vector2d> commands;
};

Script pushingScript(const Bench& bench) {
  Script script;
  script.start.tee_position = bench.shift();
  script.start.tee_yaw = 0.3;
  script.start.pusher_position = bench.shift() + Eigen::Vector2d(0.0, -0.15);
  const Eigen::Vector2d up(0.1, 0.6);
  script.commands = {up, up, {-0.2, 0.5}, {0.3, 0.4}, {0.3, 0.4}, up, {-0.3, 0.2}, {0.2, 0.7}};
  return script;
}

/// Another episode that ends in contact, in motion and with another command.
Script otherScript(const Bench& bench) {
  Script script;
  script.start.tee_position = bench.shift() + Eigen::Vector2d(0.1, 0.1);
  script.start.tee_yaw = -2.0;
  script.start.pusher_position = bench.shift() + Eigen::Vector2d(-0.05, 0.1);
  script.start.pusher_velocity = {0.5, 0.3};
  script.start.tee_yaw_rate = -2.0;
  script.commands.assign(6, {0.9, -0.3});
  return script;
}

std::vector<WorldState> run(Bench& bench, const Script& script) { return bench.run(script.start, script.commands); }

double distanceOf(const std::vector<WorldState>& a, const std::vector<WorldState>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, distanceBetween(a[i], b[i]));
  }
  return largest;
}

/// Repeats one episode, after itself, after another one, in another world.
void repetition(Bench& bench, Measurements& found) {
  const Script script = pushingScript(bench);
  run(bench, otherScript(bench));
  const std::vector<WorldState> after_other = run(bench, script);
  const std::vector<WorldState> once = run(bench, script);
  const std::vector<WorldState> again = run(bench, script);
  run(bench, otherScript(bench));
  found.set(Property::kNoise, distanceOf(once, again));
  found.set(Property::kLeak, std::max(distanceOf(once, after_other), distanceOf(once, run(bench, script))));
  if (const auto second = bench.secondWorld()) {
    Bench of_second(*second, {}, bench.seed());
    found.set(Property::kSecondWorld, distanceOf(once, run(of_second, script)));
  } else {
    found.fail(Property::kSecondWorld, "there is no second world");
  }
}

/// An episode goes on from a state that was just reported, and must go on as it would have without the reset: while
/// bodies coast, and in a straight push, where a solver that has lost its memory ends as the same.
void hiddenState(Bench& bench, Measurements& found) {
  Script coasting = otherScript(bench);
  coasting.start.pusher_position = Eigen::Vector2d::Constant(bench.narrower() - 0.3);
  coasting.commands.assign(4, {0.5, -0.3});
  Script push;
  push.start.tee_position = bench.shift();
  push.start.tee_yaw = 0.3;
  push.start.pusher_position =
      push.start.tee_position + 0.13 * Eigen::Vector2d(std::sin(push.start.tee_yaw), -std::cos(push.start.tee_yaw));
  push.commands.assign(6, 0.3 * (push.start.tee_position - push.start.pusher_position).normalized());
  double largest = 0.0;
  for (const Script& script : {coasting, push}) {
    const std::vector<WorldState> whole = run(bench, script);
    for (std::size_t step = 1; step + 1 < whole.size(); ++step) {
      bench.reset(whole[step]);
      largest = std::max(largest, distanceBetween(bench.step(script.commands[step]), whole[step + 1]));
    }
  }
  found.set(Property::kHiddenState, largest);
}

/// A tee and a pusher that move are to be elsewhere after a step.
void staleState(Bench& bench, Measurements& found) {
  WorldState start;
  start.tee_position = bench.shift();
  start.tee_velocity = {1.5, 1.0};
  start.pusher_position = Eigen::Vector2d::Constant(bench.narrower() - 0.25);
  start.pusher_velocity = {0.5, 0.0};
  constexpr int kMost = 4;
  const WorldState first = bench.reset(start);
  int stale = 0;
  while (stale < kMost && bench.step({0.0, 0.0}) == first) {
    ++stale;
  }
  found.set(Property::kStaleSteps, stale);
}

}  // namespace

std::vector<Experiment> bookkeepingExperiments() {
  return {{"start round trip",
           {Property::kRefusedStarts, Property::kStartPusherPosition, Property::kStartPusherVelocity,
            Property::kStartTeePosition, Property::kStartTeeVelocity, Property::kStartYaw, Property::kStartYawRate,
            Property::kFixedPoint},
           startRoundTrip},
          {"repetition", {Property::kNoise, Property::kLeak, Property::kSecondWorld}, repetition},
          {"reset in mid-episode", {Property::kHiddenState}, hiddenState},
          {"stale state", {Property::kStaleSteps}, staleState}};
}

}  // namespace sim2sim
