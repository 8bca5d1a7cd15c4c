// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/state_fields.hpp"
#include "pusht_task/task.hpp"

namespace pusht {
namespace {

/// [rad] Largest yaw of an initial state, before it is wrapped to [-pi, pi). Wrapping keeps 1e-13 rad of it.
constexpr double kPlausibleYaw = 1000.0;

/// Largest plausible size of a number of a state, by its unit.
constexpr double limitOf(std::string_view unit) {
  return unit == "m"     ? kPlausibleDistance
         : unit == "rad" ? kPlausibleYaw
         : unit == "m/s" ? kPlausibleSpeed
                         : kPlausibleYawRate;
}

/// Says which number of these units is too large; empty if none.
std::string faultOf(WorldState state, const std::vector<std::string>& units) {
  for (const std::string& unit : units) {
    for (const StateField& field : kStateFields) {
      if (const double value = field.of(state); field.unit == unit && std::abs(value) > limitOf(unit)) {
        return field.name + (" " + shortestText(value) + " ") + unit + ": must be within " +
               shortestText(limitOf(unit)) + " " + unit;
      }
    }
  }
  return "";
}

bool isWrapped(double yaw) { return yaw >= -kPi && yaw < kPi; }

bool isPlausible(const WorldState& state) {
  const auto is_within = [](const Eigen::Vector2d& vector, double limit) {
    return (vector.array().abs() <= limit).all();
  };
  return is_within(state.pusher_position, kPlausibleDistance) && is_within(state.tee_position, kPlausibleDistance) &&
         is_within(state.pusher_velocity, kPlausibleSpeed) && is_within(state.tee_velocity, kPlausibleSpeed) &&
         isWrapped(state.tee_yaw) && std::abs(state.tee_yaw_rate) <= kPlausibleYawRate;
}

std::string faultOfYaw(double yaw) {
  return isWrapped(yaw) ? "" : "tee_yaw " + shortestText(yaw) + " rad: must be in [-pi, pi)";
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
  if (const std::string fault = faultOf(state, {"m", "rad", "m/s", "rad/s"}); !fault.empty()) {
    throw InvalidInput("reset: " + fault);
  }
  WorldState wrapped = state;
  wrapped.tee_yaw = wrapAngle(state.tee_yaw);
  return wrapped;
}

Action checkedAction(const Action& action, const Task& task) {
  if (!isFinite(action)) {
    throw InvalidInput("step: action (" + std::to_string(action[0]) + ", " + std::to_string(action[1]) +
                       ") must be finite");
  }
  return clip(action, task);
}

std::string faultOfStart(const WorldState& start, const WorldState& state, double tolerance) {
  if (std::string fault = faultOfYaw(state.tee_yaw); !fault.empty()) {
    return fault;
  }
  WorldState wanted = start;
  WorldState found = state;
  for (const StateField& field : kStateFields) {
    const double off = field.of(found) - field.of(wanted);
    if (!field.isVelocity() && !(std::abs(field.unit == "rad" ? wrapAngle(off) : off) <= tolerance)) {
      return field.name + (" " + shortestText(field.of(found))) + ": must be within " + shortestText(tolerance) +
             " of " + shortestText(field.of(wanted));
    }
  }
  // Velocities may be projected onto what the simulator can represent; rest always can.
  const bool at_rest = std::all_of(kStateFields.begin(), kStateFields.end(), [&](const StateField& field) {
    return !field.isVelocity() || field.of(wanted) == 0.0;
  });
  for (const StateField& field : kStateFields) {
    const double value = field.of(found);
    if (field.isVelocity() && (!std::isfinite(value) || (at_rest && std::abs(value) > tolerance))) {
      return field.name + (" " + shortestText(value)) + ": must be " +
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
  if (isPlausible(state)) {  // quicker than the search for a fault, and nearly always so
    return;
  }
  if (!isFinite(state)) {
    throw SimulationFault("step: the simulation left the finite numbers");
  }
  for (const std::string& fault : {faultOf(state, {"m", "m/s", "rad/s"}), faultOfYaw(state.tee_yaw)}) {
    if (!fault.empty()) {
      throw SimulationFault("step: " + fault);
    }
  }
}

Simulator::Simulator(std::string name, double start_tolerance, const Task& task)
    : name_(std::move(name)), start_tolerance_(checkedStartTolerance(start_tolerance)), task_(&task) {}

void Simulator::reset(const WorldState& state) {
  const WorldState start = checkedStart(state);
  startChecked(start, [&] { doReset(start); });
}

void Simulator::spawn(std::uint64_t seed) { spawn(seed, pusht::spawn(seed, *task_)); }

void Simulator::spawn(std::uint64_t seed, const WorldState& drawn) {
  const WorldState start = checkedStart(drawn);
  if (!faultOfStart(pusht::spawn(seed, *task_), start).empty()) {
    throw InvalidInput("reset: the start must be the draw of seed " + std::to_string(seed));
  }
  startChecked(start, [&] { doSpawn(start, seed); });
}

template <class Reset>
void Simulator::startChecked(const WorldState& start, const Reset& reset) {
  ready_ = false;
  reset();
  inNameOf(name_, [&] { requireStart(start, this->state(), start_tolerance_); });
  ready_ = true;
}

void Simulator::step(const Action& action) {
  if (!ready_) {
    throw InvalidInput("step: the world must be reset first");
  }
  const Action clipped = checkedAction(action, *task_);
  ready_ = false;
  doStep(clipped);
  inNameOf(name_, [&] { requirePlausibleStep(state()); });
  ready_ = true;
}

}  // namespace pusht
