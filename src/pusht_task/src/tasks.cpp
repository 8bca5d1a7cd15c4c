// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/task.hpp"
#include "shipped_tasks.hpp"

namespace pusht {
namespace {

/// A sound world of gym-pusht's: a uniform tee of 1 kg. What gym-pusht leaves open has the course's proportions: the
/// rate at which a tee slows down, the pusher's mass beside the tee's, the acceleration that its drive is able to.
Physics soundPhysics() {
  constexpr double kTeeMass = 1.0;                                                     // [kg]
  constexpr double kSlowing = dynamics::kTeeDamping / (kBarMass + kStemMass);          // [1/s]
  constexpr double kPusherMass = 2.0;                                                  // [kg]
  constexpr double kMostAcceleration = dynamics::kServoLimit / dynamics::kPusherMass;  // [m/s^2]
  Physics physics;
  physics.tee_mass = kTeeMass;
  physics = withUniformTee(physics);
  physics.tee_damping = kSlowing * kTeeMass;
  physics.table_point = physics.centerOfMass();
  physics.tee_yaw_damping = kSlowing * (physics.tee_second_moment - physics.tee_first_moment * physics.centerOfMass());
  physics.tee_friction = {0.0, 0.0};
  physics.tee_yaw_friction = 0.0;
  physics.pusher_mass = kPusherMass;
  physics.drive = Drive::kPosition;
  physics.servo_stiffness = gym_pusht::kStiffness * kPusherMass;
  physics.servo_gain = gym_pusht::kDamping * kPusherMass;
  physics.servo_limit = kMostAcceleration * kPusherMass;
  physics.pusher_damping = 0.0;
  physics.wall_inner_face = gym_pusht::kWallInnerFace / gym_pusht::kPixelsPerMeter;
  return physics;
}

Task makeFullCircle() {
  Task task;
  task.name = "full_circle";
  task.action_limit = kActionLimit;
  return task;
}

Task makeGymPusht() {
  Task task;
  task.name = "gym_pusht";
  task.physics = soundPhysics();
  task.frame.unit = "px";
  task.frame.per_meter = gym_pusht::kPixelsPerMeter;
  task.frame.middle = {gym_pusht::kSide / 2.0, gym_pusht::kSide / 2.0};
  task.frame.y_down = true;
  task.frame.bar_center = gym_pusht::kBarCenter;
  const Eigen::Vector2d walls = task.frame.pointToTable({gym_pusht::kWallMiddle, gym_pusht::kWallMiddle});
  task.physics.wall_middle = {walls.x(), walls.y()};
  task.target = task.frame.poseToTable({task.frame.middle, kPi / 4.0});
  task.success.coverage = gym_pusht::kSuccessCoverage;
  task.success.hold = 1;
  task.spawn = SpawnRule::kGymPusht;
  task.first_spawn_seed = gym_pusht::kFirstSeed;
  task.last_spawn_seed = std::numeric_limits<std::uint32_t>::max();
  return task;
}

const std::array<std::reference_wrapper<const Task>, 2>& tasks() {
  static const std::array<std::reference_wrapper<const Task>, 2> all = {fullCircle(), gymPusht()};
  return all;
}

}  // namespace

const Task& fullCircle() {
  static const Task task = makeFullCircle();
  return task;
}

const Task& gymPusht() {
  static const Task task = makeGymPusht();
  return task;
}

std::vector<std::string> taskNames() {
  std::vector<std::string> names;
  std::transform(tasks().begin(), tasks().end(), std::back_inserter(names), [](const Task& task) { return task.name; });
  return names;
}

bool isShippedTask(const std::string& name) {
  return std::any_of(tasks().begin(), tasks().end(), [&](const Task& task) { return task.name == name; });
}

const Task& shippedTask(const std::string& name) {
  const auto found = std::find_if(tasks().begin(), tasks().end(), [&](const Task& task) { return task.name == name; });
  if (found == tasks().end()) {
    throw InvalidInput("task '" + name + "': must be one of: " + joined(taskNames()));
  }
  return *found;
}

}  // namespace pusht
