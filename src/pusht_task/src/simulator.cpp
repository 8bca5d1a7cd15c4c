// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/simulator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/task.hpp"

namespace pusht {
namespace {

/// [rad] Largest yaw of an initial state, before it is wrapped to [-pi, pi). Wrapping keeps 1e-13 rad of it.
constexpr double kPlausibleYaw = 1000.0;

/// A number of a world state, and how large it may be.
struct Bounded {
  const char* name;
  double value;
  double limit;
  const char* unit;
};

std::array<Bounded, 4> positionsOf(const WorldState& state) {
  return {Bounded{"pusher_x", state.pusher_position.x(), kPlausibleDistance, "m"},
          Bounded{"pusher_y", state.pusher_position.y(), kPlausibleDistance, "m"},
          Bounded{"tee_x", state.tee_position.x(), kPlausibleDistance, "m"},
          Bounded{"tee_y", state.tee_position.y(), kPlausibleDistance, "m"}};
}

std::array<Bounded, 5> velocitiesOf(const WorldState& state) {
  return {Bounded{"pusher_vx", state.pusher_velocity.x(), kPlausibleSpeed, "m/s"},
          Bounded{"pusher_vy", state.pusher_velocity.y(), kPlausibleSpeed, "m/s"},
          Bounded{"tee_vx", state.tee_velocity.x(), kPlausibleSpeed, "m/s"},
          Bounded{"tee_vy", state.tee_velocity.y(), kPlausibleSpeed, "m/s"},
          Bounded{"tee_yaw_rate", state.tee_yaw_rate, kPlausibleYawRate, "rad/s"}};
}

/// Says which of `numbers` is too large; empty if none.
template <class Numbers>
std::string faultOf(const Numbers& numbers) {
  for (const Bounded& number : numbers) {
    if (std::abs(number.value) > number.limit) {
      return std::string(number.name) + " " + shortestText(number.value) + " " + number.unit + ": must be within " +
             shortestText(number.limit) + " " + number.unit;
    }
  }
  return "";
}

std::string faultOfYaw(double yaw) {
  return yaw >= -kPi && yaw < kPi ? "" : "tee_yaw " + shortestText(yaw) + " rad: must be in [-pi, pi)";
}

/// Runs `call`; its error says whose it is.
template <class Call>
void inNameOf(const std::string& name, const Call& call) {
  try {
    call();
  } catch (Error& fault) {
    if (!name.empty()) {
      fault.addContext(name);
    }
    throw;
  }
}

}  // namespace

WorldState checkedStart(const WorldState& state) {
  if (!isFinite(state)) {
    throw InvalidInput("reset: every number of a world state must be finite");
  }
  const std::array<Bounded, 1> yaw = {Bounded{"tee_yaw", state.tee_yaw, kPlausibleYaw, "rad"}};
  for (const std::string& fault : {faultOf(positionsOf(state)), faultOf(yaw), faultOf(velocitiesOf(state))}) {
    if (!fault.empty()) {
      throw InvalidInput("reset: " + fault);
    }
  }
  WorldState wrapped = state;
  wrapped.tee_yaw = wrapAngle(state.tee_yaw);
  return wrapped;
}

Action checkedAction(const Action& action) {
  if (!isFinite(action)) {
    throw InvalidInput("step: action (" + std::to_string(action[0]) + ", " + std::to_string(action[1]) +
                       ") must be finite");
  }
  return clip(action);
}

std::string faultOfStart(const WorldState& start, const WorldState& state, double tolerance) {
  if (std::string fault = faultOfYaw(state.tee_yaw); !fault.empty()) {
    return fault;
  }
  struct Number {
    const char* name;
    double wanted;
    double found;
    double distance;
  };
  const auto number = [](const char* name, double wanted, double found) {
    return Number{name, wanted, found, std::abs(found - wanted)};
  };
  const std::array<Number, 5> pose = {
      number("pusher_x", start.pusher_position.x(), state.pusher_position.x()),
      number("pusher_y", start.pusher_position.y(), state.pusher_position.y()),
      number("tee_x", start.tee_position.x(), state.tee_position.x()),
      number("tee_y", start.tee_position.y(), state.tee_position.y()),
      Number{"tee_yaw", start.tee_yaw, state.tee_yaw, std::abs(wrapAngle(state.tee_yaw - start.tee_yaw))}};
  for (const Number& n : pose) {
    if (!(n.distance <= tolerance)) {
      return std::string(n.name) + " " + shortestText(n.found) + ": must be within " + shortestText(tolerance) +
             " of " + shortestText(n.wanted);
    }
  }
  // Velocities may be projected onto what the simulator can represent; rest always can.
  const std::array<Bounded, 5> wanted = velocitiesOf(start);
  const bool at_rest =
      std::all_of(wanted.begin(), wanted.end(), [](const Bounded& velocity) { return velocity.value == 0.0; });
  for (const Bounded& velocity : velocitiesOf(state)) {
    if (!std::isfinite(velocity.value) || (at_rest && std::abs(velocity.value) > tolerance)) {
      return std::string(velocity.name) + " " + shortestText(velocity.value) + ": must be " +
             (at_rest ? "within " + shortestText(tolerance) + " of 0" : "finite");
    }
  }
  return "";
}

void requireStart(const WorldState& start, const WorldState& state, double tolerance) {
  if (const std::string fault = faultOfStart(start, state, tolerance); !fault.empty()) {
    throw SimulationFault("reset: " + fault);
  }
}

double checkedStartTolerance(double tolerance) {
  if (!(tolerance > 0.0 && tolerance <= kStartTolerance)) {
    throw InvalidInput("start_tolerance " + shortestText(tolerance) + ": must be above 0 and at most " +
                       shortestText(kStartTolerance));
  }
  return tolerance;
}

void requirePlausibleStep(const WorldState& state) {
  if (!isFinite(state)) {
    throw SimulationFault("step: the simulation left the finite numbers");
  }
  for (const std::string& fault :
       {faultOf(positionsOf(state)), faultOf(velocitiesOf(state)), faultOfYaw(state.tee_yaw)}) {
    if (!fault.empty()) {
      throw SimulationFault("step: " + fault);
    }
  }
}

Simulator::Simulator(std::string name, double start_tolerance)
    : name_(std::move(name)), start_tolerance_(checkedStartTolerance(start_tolerance)) {}

void Simulator::reset(const WorldState& state) {
  const WorldState start = checkedStart(state);
  ready_ = false;
  doReset(start);
  inNameOf(name_, [&] { requireStart(start, this->state(), start_tolerance_); });
  ready_ = true;
}

void Simulator::step(const Action& action) {
  if (!ready_) {
    throw InvalidInput("step: the world must be reset first");
  }
  const Action clipped = checkedAction(action);
  ready_ = false;
  doStep(clipped);
  inNameOf(name_, [&] { requirePlausibleStep(state()); });
  ready_ = true;
}

}  // namespace pusht
