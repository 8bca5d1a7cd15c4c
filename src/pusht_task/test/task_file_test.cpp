// SPDX-License-Identifier: BSD-3-Clause
// Tasks as files: what they say, what they may leave out, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "pusht_task/contact.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/physics_numbers.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"

namespace pusht {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A tee of 4/3 the size.
const std::string kBigTee = R"({"name": "big", "sizes": {"bar_half_length": 0.08, "bar_half_width": 0.02,
    "stem_half_length": 0.06, "stem_half_width": 0.02, "stem_offset": 0.08}, "target": [0.05, -0.05, 0.785],
    "starts": {"ring": [0.05, 0.2], "pusher_clearance": 0.17}})";

/// JSON of a task that has `value` at `pointer`, besides a name.
std::string taskWith(const std::string& pointer, const nlohmann::json& value) {
  nlohmann::json task = {{"name", "mine"}};
  task[nlohmann::json::json_pointer(pointer)] = value;
  return task.dump();
}

std::string refusal(const std::string& text) {
  try {
    taskNamed(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(TaskFile, ThatSaysNothingIsTheCourses) {
  const std::string file = R"({"name": "mine"})";
  const Task& task = taskNamed(file);
  nlohmann::ordered_json said = describe(task);
  said["name"] = fullCircle().name;
  EXPECT_EQ(said, describe(fullCircle()));
  EXPECT_EQ(spawn(10'003, task), spawn(10'003));
}

TEST(TaskFile, IsLikeAnotherTask) {
  const std::string file = R"({"name": "mine", "like": "gym_pusht"})";
  const Task& task = taskNamed(file);
  nlohmann::ordered_json said = describe(task);
  said["name"] = gymPusht().name;
  EXPECT_EQ(said, describe(gymPusht()));
  EXPECT_EQ(spawn(100'003, task), spawn(100'003, gymPusht()));
}

TEST(TaskFile, IsJudgedByTheTolerancesThatItHas) {
  const std::string file =
      R"({"name": "mine", "like": "gym_pusht", "success": {"position": 0.02}, "starts": {"rule": "ring"}})";
  const Task& task = taskNamed(file);
  EXPECT_FALSE(task.success.coverage);
  EXPECT_EQ(task.last_spawn_seed, fullCircle().last_spawn_seed) << "seeds of a ring have 64 bits";
}

TEST(TaskFile, HasATextThatReadsAsTheSameTask) {
  const Task& task = taskNamed(kBigTee);
  EXPECT_EQ(&taskNamed(textOf(task)), &task) << "one task for one text, wherever it comes from";
  EXPECT_EQ(textOf(gymPusht()), "gym_pusht");
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "task_file_test_big.json";
  writeFile(file, kBigTee);
  EXPECT_EQ(&taskNamed(file.string()), &task);
  std::filesystem::remove(file);
}

/// A uniform tee of 4/3 the size and the same mass: moments grow by 4/3 and by 16/9.
TEST(TaskFile, OfOtherSizesHasTheMomentsOfAUniformTee) {
  const Physics& big = taskNamed(kBigTee).physics;
  const Physics course;
  EXPECT_EQ(big.tee_mass, course.tee_mass);
  EXPECT_NEAR(big.tee_first_moment, 4.0 / 3.0 * course.tee_first_moment, 1e-15);
  EXPECT_NEAR(big.tee_second_moment, 16.0 / 9.0 * course.tee_second_moment, 1e-15);
  const Physics heavy = taskNamed(taskWith("/physics/tee_body_mass", 0.21)).physics;
  EXPECT_NEAR(heavy.tee_second_moment, 2.0 * course.tee_second_moment, 1e-15);
}

TEST(TaskFile, StartsClearOfEverything) {
  const Task& task = taskNamed(kBigTee);
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const WorldState start = spawn(seed, task);
    const double radius = (start.tee_position - task.target.position).norm();
    EXPECT_GE(radius, 0.05 - 1e-15);
    EXPECT_LE(radius, 0.2 + 1e-15);
    EXPECT_LE(deepestOverlap(start, task).depth, 0.0) << seed;
    EXPECT_FALSE(isSolved(start, task)) << seed;
  }
  EXPECT_TRUE(isSolved(stateAtTarget(task), task));
  EXPECT_NEAR(coverageOf(stateAtTarget(task), task), 1.0, 1e-12);
}

/// The pusher above the middle of the big bar, 1 mm off.
TEST(TaskFile, HasItsOwnContacts) {
  WorldState state;
  state.pusher_position = {0.0, 0.036};
  const Task& task = taskNamed(kBigTee);
  EXPECT_NEAR(contactsOf(state, task).bar.gap, 0.001, 1e-15);
  EXPECT_NEAR(wallGapsOf(state, task).tee, 0.39 - 0.14, 1e-15);
}

TEST(TaskFile, RefusesWhatIsNone) {
  EXPECT_EQ(refusal("ful_circle"), "task 'ful_circle': must be one of: full_circle, gym_pusht; or a file NAME.json");
  EXPECT_THAT(refusal("no_such.json"), HasSubstr("no_such.json"));
  EXPECT_EQ(refusal("{"), "task: must be a JSON object {...}");
  EXPECT_THAT(refusal("{}"), StartsWith("task: name '': must be a word"));
  EXPECT_THAT(refusal(R"({"name": "gym_pusht"})"), HasSubstr("not be one of: full_circle, gym_pusht"));
  EXPECT_THAT(refusal(R"({"name": "../mine"})"), StartsWith("task: name '../mine': must be a word"));
  EXPECT_THAT(refusal(taskWith("/like", "mine")), StartsWith("task: task 'mine': must be one of"));
  EXPECT_THAT(refusal(taskWith("/size", 1)), StartsWith("task: size: unknown; known: action_limit, frame, like"));
  EXPECT_THAT(refusal(taskWith("/sizes/bar", 1)), StartsWith("task: sizes.bar: unknown; known: bar_half_length"));
  EXPECT_EQ(refusal(taskWith("/sizes", 1)), "task: sizes is 1: must be an object {...}");
}

TEST(TaskFile, RefusesValuesByTheirRule) {
  EXPECT_EQ(refusal(taskWith("/sizes/pusher_radius", -0.01)),
            "task: sizes.pusher_radius -0.01: must be a number from 1e-06 to 10.0");
  EXPECT_EQ(refusal(taskWith("/physics/drive", "force")),
            "task: physics.drive \"force\": must be one of: position, velocity");
  EXPECT_EQ(refusal(taskWith("/frame/y_down", 1)), "task: frame.y_down 1: must be true or false");
  EXPECT_EQ(refusal(taskWith("/success/hold", 0)), "task: success.hold 0: must be an integer from 1 to 300");
  EXPECT_EQ(refusal(taskWith("/target", {0.0, 0.0})), "task: target [0.0,0.0]: must be 3 numbers [...]");
  EXPECT_THAT(refusal(taskWith("/target", {0.35, 0.0, 0.0})),
              StartsWith("task: target: must be between the walls; a tee there is "));
  EXPECT_EQ(refusal(R"({"name": "mine", "like": "gym_pusht", "physics": {"drive": "velocity"}})"),
            "task: physics.drive velocity: must be position in a frame of its own: velocities are the table's, m/s");
  EXPECT_EQ(refusal(taskWith("/physics/drive", "position")),
            "task: physics.servo_stiffness 0.0: must be above 0 in a drive to a position");
  EXPECT_THAT(refusal(taskWith("/physics/tee_second_moment", 1e-6)), HasSubstr("the center of mass's share of it"));
  EXPECT_EQ(refusal(taskWith("/starts/ring", {0.2, 0.1})), "task: starts.ring 0.2, 0.1: must be in order");
  EXPECT_EQ(refusal(taskWith("/starts/pusher_clearance", 3.0)),
            "task: starts of the task mine: the pusher finds no place in 10000 draws");
}

TEST(PhysicsNumbers, AreOfTheTaskUnlessTheyAreSet) {
  ParameterSet set(physicsDescriptors());
  EXPECT_FALSE(set.at("tee_damping").isRecorded());
  set.set("tee_damping", "2.5");
  EXPECT_TRUE(set.at("tee_damping").isRecorded());
  const Physics physics = physicsWith(set, gymPusht().physics);
  for (const PhysicsNumber& number : physicsNumbers()) {
    const double expected = number.descriptor.name == "tee_damping" ? 2.5 : number.of(gymPusht().physics);
    EXPECT_EQ(number.of(physics), expected) << number.descriptor.name;
  }
}

TEST(PhysicsNumbers, ATeeOfAnotherMassHasItsShares) {
  ParameterSet set(physicsDescriptors());
  set.set("tee_body_mass", "0.21");
  const Physics physics = physicsWith(set, {});
  const Physics course;
  EXPECT_NEAR(physics.tee_second_moment, 2.0 * course.tee_second_moment, 1e-15);
  EXPECT_NEAR(physics.centerOfMass(), course.centerOfMass(), 1e-15);
}

TEST(PhysicsNumbers, EachIsReadWhereItIsSet) {
  for (const PhysicsNumber& number : physicsNumbers()) {
    Physics physics;
    EXPECT_EQ(number.of(physics), std::get<double>(number.descriptor.default_value)) << number.descriptor.name;
    number.set(physics, 1.75);
    EXPECT_EQ(number.of(physics), 1.75) << number.descriptor.name;
  }
}

TEST(AtPointOfTee, GoesThereAndBack) {
  WorldState state;
  state.tee_position = {0.1, -0.2};
  state.tee_yaw = 0.7;
  state.tee_velocity = {0.3, 0.4};
  state.tee_yaw_rate = 2.0;
  const WorldState there = atPointOfTee(state, 0.05);
  EXPECT_NEAR((there.tee_position - state.tee_position - 0.05 * Eigen::Vector2d(std::sin(0.7), -std::cos(0.7))).norm(),
              0.0, 1e-15);
  EXPECT_NEAR((there.tee_velocity - state.tee_velocity - 0.1 * Eigen::Vector2d(std::cos(0.7), std::sin(0.7))).norm(),
              0.0, 1e-15);
  const WorldState back = atPointOfTee(there, -0.05);
  EXPECT_NEAR((back.tee_position - state.tee_position).norm(), 0.0, 1e-15);
  EXPECT_NEAR((back.tee_velocity - state.tee_velocity).norm(), 0.0, 1e-15);
  EXPECT_EQ(atPointOfTee(state, 0.0), state);
}

}  // namespace
}  // namespace pusht
