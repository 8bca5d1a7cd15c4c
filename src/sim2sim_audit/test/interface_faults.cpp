// SPDX-License-Identifier: BSD-3-Clause
// Faults at the interface of a world, which any kind can have.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "faulty.hpp"
#include "planted_faults.hpp"
#include "pusht_task/constants.hpp"

namespace sim2sim::testing {
namespace {

using pusht::WorldState;
using P = Property;

PlantedFault atTheInterface(std::string name, std::vector<Property> named_by, const InterfaceFault& fault) {
  const auto over = [fault](const WorldFactory& make) -> WorldFactory {
    return [=] { return std::make_unique<Faulty>(make(), fault); };
  };
  return {std::move(name), std::move(named_by), over(cleanMujoco()), over(cleanChipmunk()), over(cleanRigidBody())};
}

/// Fault of what a state says, read and written in the same wrong way.
InterfaceFault both(InterfaceFault::OfState start, InterfaceFault::OfState report) {
  InterfaceFault fault;
  fault.start = std::move(start);
  fault.report = std::move(report);
  return fault;
}

InterfaceFault ofCommands(InterfaceFault::OfAction command) {
  InterfaceFault fault;
  fault.command = std::move(command);
  return fault;
}

InterfaceFault::OfState velocitiesTimes(double factor) {
  return [factor](WorldState state) {
    state.pusher_velocity *= factor;
    state.tee_velocity *= factor;
    state.tee_yaw_rate *= factor;
    return state;
  };
}

InterfaceFault::OfState yawTimes(double factor) {
  return [factor](WorldState state) {
    state.tee_yaw = pusht::wrapAngle(factor * state.tee_yaw);
    state.tee_yaw_rate *= factor;
    return state;
  };
}

InterfaceFault::OfState yawPlus(double offset) {
  return [offset](WorldState state) {
    state.tee_yaw = pusht::wrapAngle(state.tee_yaw + offset);
    return state;
  };
}

const Eigen::Vector2d kCenterOfMass(0.0, -pusht::kCenterOfMassOffset);  // [m] body frame

InterfaceFault::OfState placeOf(const Eigen::Vector2d& point) {
  return [point](const WorldState& state) { return movedTo(state, point); };
}

/// The tee's velocity plus that of a point against the origin's.
InterfaceFault::OfState velocityOf(const Eigen::Vector2d& point) {
  return [point](WorldState state) {
    state.tee_velocity = movedTo(state, point).tee_velocity;
    return state;
  };
}

InterfaceFault::OfState velocityTurned(double times_yaw) {
  return [times_yaw](WorldState state) {
    state.tee_velocity = Eigen::Rotation2Dd(times_yaw * state.tee_yaw) * state.tee_velocity;
    return state;
  };
}

WorldState pusherVelocitySwapped(WorldState state) {
  std::swap(state.pusher_velocity.x(), state.pusher_velocity.y());
  return state;
}

/// The tee's position and velocity along other axes: a world in which the table is elsewhere.
InterfaceFault::OfState tableMoved(const Eigen::Vector2d& by) {
  return [by](WorldState state) {
    state.tee_position += by;
    state.pusher_position += by;
    return state;
  };
}

}  // namespace

std::vector<PlantedFault> interfaceFaults() {
  InterfaceFault late;
  late.delay = 1;
  InterfaceFault very_late;
  very_late.delay = 2;
  InterfaceFault stale;
  stale.stale = true;
  InterfaceFault noisy;
  noisy.noise = 1e-4;
  InterfaceFault leaking;
  leaking.leak = 0.02;
  InterfaceFault warm;
  warm.leak = 1e-6;
  InterfaceFault projecting;
  projecting.start = [](WorldState state) {
    state.tee_yaw_rate = std::max(-5.0, std::min(5.0, state.tee_yaw_rate));
    return state;
  };
  const double degree = pusht::kPi / 180.0;
  using A = pusht::Action;
  const std::vector<Property> of_velocities = {P::kPusherVelocityFactor, P::kTeeVelocityFactor, P::kYawRateFactor};
  const std::vector<Property> of_axes = {P::kAxesTurn, P::kAxesMirror};
  return {
      atTheInterface("delay of one step", {P::kDelay}, late),
      atTheInterface("delay of two steps", {P::kDelay}, very_late),
      atTheInterface("stale state", {P::kStaleSteps}, stale),
      atTheInterface("action times 0.9", {P::kActionScaleX, P::kActionScaleY}, ofCommands([](const A& a) {
                       return A{0.9F * a[0], 0.9F * a[1]};
                     })),
      atTheInterface("action times 0.9 along y", {P::kActionScaleY}, ofCommands([](const A& a) {
                       return A{a[0], 0.9F * a[1]};
                     })),
      atTheInterface("axes of the action swapped", of_axes, ofCommands([](const A& a) {
                       return A{a[1], a[0]};
                     })),
      atTheInterface("y of the action mirrored", of_axes, ofCommands([](const A& a) {
                       return A{a[0], -a[1]};
                     })),
      atTheInterface("clip at 0.9", {P::kActionLimit}, ofCommands([](const A& a) {
                       return A{std::max(-0.9F, std::min(0.9F, a[0])), std::max(-0.9F, std::min(0.9F, a[1]))};
                     })),
      atTheInterface("action off by 0.05 along x", {P::kRestMotion}, ofCommands([](const A& a) {
                       return A{a[0] + 0.05F, a[1]};
                     })),
      atTheInterface("dead band of 0.03", {P::kSmallCommand}, ofCommands([](const A& a) {
                       return A{std::abs(a[0]) < 0.03F ? 0.0F : a[0], std::abs(a[1]) < 0.03F ? 0.0F : a[1]};
                     })),
      atTheInterface("axes of the pusher's velocity swapped", {P::kPusherVelocityFactor},
                     both(pusherVelocitySwapped, pusherVelocitySwapped)),
      atTheInterface("sense of the yaw", {P::kYawGain}, both(yawTimes(-1.0), yawTimes(-1.0))),
      atTheInterface("yaw off by 0.1", {P::kYawOffset}, both(yawPlus(-0.1), yawPlus(0.1))),
      atTheInterface("yaw in degrees", {P::kYawGain}, both(yawTimes(degree), yawTimes(1.0 / degree))),
      atTheInterface("origin at the center of mass", {P::kOriginY},
                     both(placeOf(-kCenterOfMass), placeOf(kCenterOfMass))),
      atTheInterface("velocity of the center of mass", {P::kTeeVelocityPoint},
                     both(velocityOf(-kCenterOfMass), velocityOf(kCenterOfMass))),
      atTheInterface("velocity in body axes", {P::kTeeVelocityFrame}, both(velocityTurned(1.0), velocityTurned(-1.0))),
      atTheInterface("velocities times 2", of_velocities, both(velocitiesTimes(0.5), velocitiesTimes(2.0))),
      atTheInterface("reported velocities times 2", of_velocities,
                     both([](const WorldState& s) { return s; }, velocitiesTimes(2.0))),
      atTheInterface("table off by 5 mm", {P::kWallRight, P::kWallLeft},
                     both(tableMoved({-0.005, 0.0}), tableMoved({0.005, 0.0}))),
      atTheInterface("state that leaks over a reset", {P::kLeak}, leaking),
      atTheInterface("warm start that leaks", {P::kLeak}, warm),
      atTheInterface("noise of 1e-4", {P::kNoise}, noisy),
      atTheInterface("start that is quietly projected", {P::kStartYawRate}, projecting),
  };
}

}  // namespace sim2sim::testing
