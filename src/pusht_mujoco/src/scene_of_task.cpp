// SPDX-License-Identifier: BSD-3-Clause
#include "scene_of_task.hpp"

#include <array>
#include <cstring>
#include <initializer_list>
#include <memory>

#include "mujoco_guard.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht {
namespace {

constexpr double kWallMiddle = 0.03;       // [m] height of the walls' center, and half of theirs
constexpr double kTeeHeight = 0.0152;      // [m] of the tee's center, which never touches the table
constexpr double kTeeHalfHeight = 0.015;   // [m]
constexpr double kPusherHeight = 0.02;     // [m] of the pusher's center, and half of its own
constexpr double kRollFriction = 0.005;    // [m] MuJoCo's default of geom's friction[1]
constexpr double kTwistFriction = 0.0001;  // [m] MuJoCo's default of geom's friction[2]

/// "NAME=\"1.0 2.0\" ", an attribute.
std::string attribute(const char* name, std::initializer_list<double> numbers) {
  std::string text = std::string(name) + "=\"";
  for (const double number : numbers) {
    text += (text.back() == '"' ? "" : " ") + shortestText(number);
  }
  return text + "\" ";
}

std::string joint(const char* name, const char* type_and_axis, double damping, double friction) {
  return std::string("<joint name=\"") + name + "\" " + type_and_axis + " " + attribute("damping", {damping}) +
         attribute("frictionloss", {friction}) + "/>\n";
}

std::string geom(const std::string& name, const char* type, std::initializer_list<double> place,
                 std::initializer_list<double> size, double mass) {
  return "<geom name=\"" + name + "\" type=\"" + type + "\" " + attribute("pos", place) + attribute("size", size) +
         (mass > 0.0 ? attribute("mass", {mass}) : "") + "/>\n";
}

/// What drives the pusher along an axis: force = gain * command + bias of position and velocity, within limits.
std::string actuator(const char* axis, const Task& task) {
  const Physics& physics = task.physics;
  const std::string begin = std::string(" name=\"pusher_") + axis + "\" joint=\"pusher_" + axis + "\" ";
  const std::string limits = attribute("forcerange", {-physics.servo_limit, physics.servo_limit});
  const double most = task.action_limit.value_or(0.0F);
  const std::string range = most > 0.0 && task.frame.isTables() ? attribute("ctrlrange", {-most, most}) : "";
  if (physics.drive == Drive::kVelocity) {
    return "<velocity" + begin + attribute("kv", {physics.servo_gain}) + range + limits + "/>\n";
  }
  return "<general" + begin + "biastype=\"affine\" " + attribute("gainprm", {physics.servo_stiffness}) +
         attribute("biasprm", {0.0, -physics.servo_stiffness, -physics.servo_gain}) + limits + "/>\n";
}

/// Masses [kg] of bar and stem from those of the tee, whose moments are then those of boxes.
std::array<double, 2> massesOf(const Physics& physics) {
  const double stem = physics.tee_first_moment / physics.stem_offset;
  return {physics.tee_mass - stem, stem};
}

void requireBoxes(const Task& task) {
  const auto [bar, stem] = massesOf(task.physics);
  const double of_boxes = momentOfTee(bar, stem, task.physics);
  if (!(bar > 0.0 && stem > 0.0 && std::abs(of_boxes - task.physics.tee_second_moment) <= 1e-9 * of_boxes)) {
    throw InvalidInput("task " + task.name + ": physics.tee_second_moment " +
                       shortestText(task.physics.tee_second_moment) + " must be " + shortestText(of_boxes) +
                       ", that of bar and stem of the tee's mass and first moment, in mujoco");
  }
}

}  // namespace

std::string sceneOf(const Task& task) {
  requireBoxes(task);
  const Physics& physics = task.physics;
  const auto [bar_mass, stem_mass] = massesOf(physics);
  const double up = physics.table_point;  // [m] from the body's origin to the tee's, along body y
  std::string xml = "<mujoco model=\"" + task.name + "\">\n<compiler autolimits=\"true\"/>\n" +
                    "<option timestep=\"0.01\" integrator=\"implicit\"/>\n<default><geom " +
                    attribute("friction", {physics.contact_friction, kRollFriction, kTwistFriction}) +
                    "/></default>\n<worldbody>\n";
  const std::array names = {"wall_y_plus", "wall_y_minus", "wall_x_plus", "wall_x_minus"};
  const auto walls = wallBoxes(physics);
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const PlacedBox& wall = walls[i];
    xml += geom(names[i], "box", {wall.x, wall.y, kWallMiddle}, {wall.half_x, wall.half_y, kWallMiddle}, 0.0);
  }
  xml +=
      "<body name=\"tee\" " + attribute("pos", {0.0, 0.0, kTeeHeight}) + ">\n" +
      joint("tee_x", "type=\"slide\" axis=\"1 0 0\"", physics.tee_damping, physics.tee_friction[0]) +
      joint("tee_y", "type=\"slide\" axis=\"0 1 0\"", physics.tee_damping, physics.tee_friction[1]) +
      joint("tee_yaw", "type=\"hinge\" axis=\"0 0 1\"", physics.tee_yaw_damping, physics.tee_yaw_friction) +
      geom("bar", "box", {0.0, up, 0.0}, {physics.bar_half_length, physics.bar_half_width, kTeeHalfHeight}, bar_mass) +
      geom("stem", "box", {0.0, up - physics.stem_offset, 0.0},
           {physics.stem_half_width, physics.stem_half_length, kTeeHalfHeight}, stem_mass) +
      "</body>\n<body name=\"pusher\" " + attribute("pos", {0.0, 0.0, kPusherHeight}) + ">\n" +
      joint("pusher_x", "type=\"slide\" axis=\"1 0 0\"", physics.pusher_damping, 0.0) +
      joint("pusher_y", "type=\"slide\" axis=\"0 1 0\"", physics.pusher_damping, 0.0) +
      geom("pusher", "cylinder", {0.0, 0.0, 0.0}, {physics.pusher_radius, kPusherHeight}, physics.pusher_mass) +
      "</body>\n</worldbody>\n<actuator>\n" + actuator("x", task) + actuator("y", task) + "</actuator>\n</mujoco>\n";
  return xml;
}

MujocoModel compiledScene(const std::string& xml) {
  constexpr const char* kFile = "pusht.xml";
  const auto files = std::make_unique<mjVFS>();
  std::array<char, 1000> message{};
  MujocoModel model;
  MujocoGuard::run([&] {
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), kFile, static_cast<int>(xml.size()));
    std::memcpy(files->filedata[0], xml.data(), xml.size());
    model.reset(mj_loadXML(kFile, files.get(), message.data(), static_cast<int>(message.size())));
    mj_deleteVFS(files.get());
  });
  if (model == nullptr) {
    throw InternalError(std::string("MuJoCo does not load a scene of the suite: ") + message.data());
  }
  return model;
}

}  // namespace pusht
