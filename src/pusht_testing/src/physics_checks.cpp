// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_testing/physics_checks.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "plain_motions.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/types.hpp"

namespace pusht::testing {

void Deviations::expectNear(const std::string& what, double found, double expected, double tolerance) {
  ++expected_;
  if (!(std::abs(found - expected) <= tolerance)) {
    add(std::abs(found - expected) / tolerance, what + ": " + significantText(found, 6) + ", must be " +
                                                    significantText(expected, 6) + " +- " +
                                                    significantText(tolerance, 3));
  }
}

void Deviations::expect(bool holds, const std::string& what) {
  ++expected_;
  if (!holds) {
    add(std::numeric_limits<double>::infinity(), what);
  }
}

void Deviations::add(double excess, const std::string& what) {
  const double size = std::isnan(excess) ? std::numeric_limits<double>::infinity() : excess;
  if (count_ == 0 || size > most_) {
    most_ = size;
    what_ = what;
  }
  ++count_;
}

std::string Deviations::summary() const {
  return count_ == 0 ? ""
                     : std::to_string(count_) + " of " + std::to_string(expected_) + " figures deviate; most: " + what_;
}

namespace physics {
namespace {

/// Rotations of a scene by quarters of a turn: the table has two axes, and four walls.
constexpr int kQuarters = 4;

/// Vector turned by quarters of a turn, counterclockwise.
Eigen::Vector2d turned(const Eigen::Vector2d& vector, int quarters) {
  Eigen::Vector2d result = vector;
  for (int i = 0; i < quarters; ++i) {
    result = Eigen::Vector2d(-result.y(), result.x());
  }
  return result;
}
/// State turned about the target by quarters of a turn, counterclockwise.
WorldState turned(const WorldState& state, int quarters) {
  WorldState result = state;
  for (Eigen::Vector2d WorldState::*vector : {&WorldState::pusher_position, &WorldState::pusher_velocity,
                                              &WorldState::tee_position, &WorldState::tee_velocity}) {
    result.*vector = turned(state.*vector, quarters);
  }
  result.tee_yaw = wrapAngle(state.tee_yaw + quarters * kPi / 2.0);
  return result;
}
/// Action with the components of a commanded velocity [m/s].
Action actionOf(const Eigen::Vector2d& command) {
  return {static_cast<float>(command.x()), static_cast<float>(command.y())};
}
/// Takes `count` control steps with one command [m/s].
void steps(Simulator& world, const Eigen::Vector2d& command, int count) {
  for (int i = 0; i < count; ++i) {
    world.step(actionOf(command));
  }
}
/// Index into Physics::tee_friction of the table's axis that the x direction lies along after a turn.
std::size_t axisOfX(int quarters) { return quarters % 2 == 0 ? 0 : 1; }

/// The pusher in free space after each of three control steps.
void followPusher(const std::string& what, Simulator& world, const PhysicsOfKind& physics, const WorldState& start,
                  const Eigen::Vector2d& command, Deviations& deviations) {
  world.reset(start);
  const Action action = actionOf(command);
  std::array<PlainPusher, 2> axes = {PlainPusher{start.pusher_position.x(), start.pusher_velocity.x()},
                                     PlainPusher{start.pusher_position.y(), start.pusher_velocity.y()}};
  for (int step = 1; step <= 3; ++step) {
    world.step(action);
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      PlainPusher& plain = axes[static_cast<std::size_t>(axis)];
      plain.controlStep(physics, action[static_cast<std::size_t>(axis)]);
      const std::string where = what + ", axis " + "xy"[axis] + ", step " + std::to_string(step);
      deviations.expectNear(where + " [m]", world.state().pusher_position[axis], plain.position, physics.free_position);
      deviations.expectNear(where + " [m/s]", world.state().pusher_velocity[axis], plain.velocity, physics.free_speed);
    }
  }
}

/// The tee, left alone, after each of two control steps.
void followTee(const std::string& what, Simulator& world, const PhysicsOfKind& physics, double yaw,
               const Eigen::Vector3d& velocity, Deviations& deviations) {
  WorldState start;
  start.tee_yaw = yaw;
  start.tee_position = -0.05 * velocity.head<2>();
  start.tee_velocity = velocity.head<2>();
  start.tee_yaw_rate = velocity[2];
  start.pusher_position = {0.36, 0.36};
  world.reset(start);
  PlainTee plain = {{start.tee_position.x(), start.tee_position.y(), yaw}, velocity};
  for (int step = 1; step <= 2; ++step) {
    world.step({0.0F, 0.0F});
    plain.controlStep(physics);
    const WorldState state = world.state();
    const std::string where = what + ", step " + std::to_string(step);
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      const std::string of_axis = where + ", axis " + "xy"[axis];
      deviations.expectNear(of_axis + " [m]", state.tee_position[axis], plain.pose[axis], physics.free_position);
      deviations.expectNear(of_axis + " [m/s]", state.tee_velocity[axis], plain.velocity[axis], physics.free_speed);
    }
    deviations.expectNear(where + ", yaw [rad]", plain.pose[2] + wrapAngle(state.tee_yaw - plain.pose[2]),
                          plain.pose[2], physics.free_yaw);
    deviations.expectNear(where + ", yaw rate [rad/s]", state.tee_yaw_rate, plain.velocity[2],
                          physics.free_speed / PhysicsOfKind::kLever);
  }
}

/// The pusher below the stem's end (at yaw 0), just in touch; a push along +y goes through the center of mass.
WorldState behindTheStem(const Physics& p, const Eigen::Vector2d& tee) {
  WorldState start;
  start.tee_position = tee;
  constexpr double kOverlap = 2e-4;  // [m]
  start.pusher_position = tee - Eigen::Vector2d(0.0, p.stem_offset + p.stem_half_length + p.pusher_radius - kOverlap);
  return start;
}

}  // namespace

Deviations servo(Simulator& world, const PhysicsOfKind& physics) {
  Deviations deviations;
  WorldState start;
  start.tee_position = {0.25, 0.25};
  start.pusher_position = {-0.2, -0.2};
  followPusher("servo from rest", world, physics, start, {0.5, -0.25}, deviations);
  start.pusher_velocity = {-0.4, 0.7};
  followPusher("servo from a velocity", world, physics, start, {0.0, 1.0}, deviations);
  return deviations;
}

Deviations servoLimit(Simulator& world, const PhysicsOfKind& physics) {
  Deviations deviations;
  WorldState start;
  start.tee_position = {0.25, -0.25};
  start.pusher_position = {0.2, 0.0};
  start.pusher_velocity = {-6.0, 0.0};
  followPusher("servo at its limit along x", world, physics, start, {1.0, 0.0}, deviations);
  start.pusher_position = {0.0, 0.2};
  start.pusher_velocity = {0.0, -6.0};
  followPusher("servo at its limit along y", world, physics, start, {0.0, 1.0}, deviations);
  return deviations;
}

Deviations slide(Simulator& world, const PhysicsOfKind& physics) {
  Deviations deviations;
  for (int quarters = 0; quarters < kQuarters; ++quarters) {
    const Eigen::Vector2d along = turned({0.0, -1.0}, quarters);
    const double yaw = quarters * kPi / 2.0;
    for (const double speed : {0.3, 0.6, 3.0, -3.0}) {
      followTee("slide at " + significantText(speed, 2) + " m/s along the centers, yaw " + significantText(yaw, 3),
                world, physics, yaw, {speed * along.x(), speed * along.y(), 0.0}, deviations);
    }
    const Eigen::Vector2d diagonal = turned({std::sqrt(0.5), -std::sqrt(0.5)}, quarters);
    for (const double speed : {0.4, 0.8}) {
      followTee("slide at " + significantText(speed, 2) + " m/s in the diagonal", world, physics, yaw + kPi / 4.0,
                {speed * diagonal.x(), speed * diagonal.y(), 0.0}, deviations);
    }
  }
  return deviations;
}

Deviations slideAcross(Simulator& world, const PhysicsOfKind& physics) {
  Deviations deviations;
  for (const double yaw : {0.0, 0.7, kPi / 2.0, 3.0}) {
    for (const double speed : {0.3, 1.0, -1.0}) {
      followTee("slide at " + significantText(speed, 2) + " m/s across the centers, yaw " + significantText(yaw, 3),
                world, physics, yaw, {speed * std::cos(yaw), speed * std::sin(yaw), 0.0}, deviations);
    }
  }
  return deviations;
}

Deviations spin(Simulator& world, const PhysicsOfKind& physics) {
  Deviations deviations;
  for (const double yaw : {0.0, 2.0}) {
    for (const double rate : {0.7, -0.7, 4.0}) {
      const std::string what = "spin at " + significantText(rate, 2) + " rad/s, yaw " + significantText(yaw, 3);
      followTee(what + ", about the origin", world, physics, yaw, {0.0, 0.0, rate}, deviations);
      const double of_origin = -rate * physics.numbers.centerOfMass();  // [m/s] along body x
      followTee(what + ", about the center of mass", world, physics, yaw,
                {of_origin * std::cos(yaw), of_origin * std::sin(yaw), rate}, deviations);
    }
  }
  return deviations;
}

Deviations push(Simulator& world, const PhysicsOfKind& physics) {
  Deviations deviations;
  for (int quarters = 0; quarters < kQuarters; ++quarters) {
    const Physics& p = physics.numbers;
    const WorldState start = turned(behindTheStem(p, {0.0, -0.05}), quarters);
    const Eigen::Vector2d along = turned({0.0, 1.0}, quarters);
    const std::string what = "push, " + std::to_string(quarters) + " quarters turned";
    world.reset(start);
    PlainPush plain;
    for (int step = 1; step <= 3; ++step) {
      steps(world, 0.6 * along, 1);
      plain.controlStep(physics, 0.6F, p.tee_friction[axisOfX(quarters + 1)]);
      const WorldState state = world.state();
      deviations.expectNear(what + ", travel of the tee [m]", (state.tee_position - start.tee_position).dot(along),
                            plain.travel, physics.push_position);
      deviations.expectNear(what + ", travel of the pusher [m]",
                            (state.pusher_position - start.pusher_position).dot(along), plain.travel,
                            physics.push_position);
    }
    deviations.expectNear(what + ", speed of the tee [m/s]", world.state().tee_velocity.dot(along), plain.velocity,
                          physics.push_speed);
  }
  return deviations;
}

Deviations sizes(Simulator& world, const PhysicsOfKind& physics) {
  struct Face {
    const char* name;
    Eigen::Vector2d center;   // [m] of bar or stem, in the body frame
    Eigen::Vector2d outward;  // in the body frame
    double half;              // [m] from that center to the face
  };
  const Physics& p = physics.numbers;
  const Eigen::Vector2d stem(0.0, -p.stem_offset);
  const std::array<Face, 6> faces = {{
      {"bar's back", {0.0, 0.0}, {0.0, 1.0}, p.bar_half_width},
      {"bar's end on +x", {0.0, 0.0}, {1.0, 0.0}, p.bar_half_length},
      {"bar's end on -x", {0.0, 0.0}, {-1.0, 0.0}, p.bar_half_length},
      {"stem's end", stem, {0.0, -1.0}, p.stem_half_length},
      {"stem's side on +x", stem, {1.0, 0.0}, p.stem_half_width},
      {"stem's side on -x", stem, {-1.0, 0.0}, p.stem_half_width},
  }};
  constexpr double kApart = 0.002;  // [m]
  constexpr double kSlow = 0.2;     // [m/s]
  Deviations deviations;
  for (const Face& face : faces) {
    const double reach = face.half + p.pusher_radius;
    WorldState start;
    start.pusher_position = face.center + (reach + kApart) * face.outward;
    world.reset(start);
    steps(world, {0.0, 0.0}, 1);
    deviations.expectNear(std::string(face.name) + ": tee moves untouched [m]",
                          (world.state().tee_position - start.tee_position).norm(), 0.0, 1e-9);
    steps(world, -kSlow * face.outward, 2);
    const WorldState state = world.state();
    const Eigen::Rotation2Dd yaw(state.tee_yaw);
    const Eigen::Vector2d found = yaw.inverse() * (state.pusher_position - state.tee_position) - face.center;
    deviations.expectNear(std::string(face.name) + ": pusher's distance when it pushes [m]",
                          physics.discs ? found.norm() : found.dot(face.outward), reach, physics.contact_position);
    deviations.expect((state.tee_position - start.tee_position).norm() + 0.1 * std::abs(state.tee_yaw) > 1e-3,
                      std::string(face.name) + ": the tee is not pushed");
  }
  return deviations;
}

Deviations walls(Simulator& world, const PhysicsOfKind& physics) {
  const Physics& p = physics.numbers;
  const double thickness = 0.5 * dynamics::kWallThickness;  // [m] beyond its face; well within a wall
  Deviations deviations;
  for (int quarters = 0; quarters < kQuarters; ++quarters) {
    const Eigen::Vector2d along = turned({0.0, 1.0}, quarters);
    const std::string of_wall = " at the wall " + std::to_string(quarters) + " quarters from +y [m]";
    WorldState start;
    start.tee_position = turned({-0.2, -0.2}, quarters);
    start.pusher_position = turned({0.1, 0.3}, quarters);
    world.reset(start);
    steps(world, 0.3 * along, 8);
    const double pusher = world.state().pusher_position.dot(along);
    start = turned(behindTheStem(p, {0.1, p.wall_inner_face - p.bar_half_width - 0.05}), quarters);
    world.reset(start);
    steps(world, 0.6 * along, 8);
    const double tee = world.state().tee_position.dot(along);
    if (physics.walls) {
      deviations.expectNear("pusher" + of_wall, pusher, p.wall_inner_face - p.pusher_radius, physics.contact_position);
      deviations.expectNear("tee" + of_wall, tee, p.wall_inner_face - p.bar_half_width, physics.contact_position);
    } else {
      deviations.expect(pusher > p.wall_inner_face + thickness, "something stops the pusher" + of_wall);
      deviations.expect(tee > p.wall_inner_face + thickness, "something stops the tee" + of_wall);
    }
  }
  return deviations;
}

Deviations contactFriction(Simulator& world, const PhysicsOfKind& physics) {
  const Physics& p = physics.numbers;
  const double damping = p.servo_gain + p.pusher_damping;
  constexpr int kSteps = 14;
  Deviations deviations;
  // [m/s] Speed along the face, pressed with `press` [m/s] and told to slip with `slip` [m/s].
  const auto expected = [&](double press, double slip) {
    return std::max(0.0, p.servo_gain * (slip - p.contact_friction * press) / damping);
  };
  for (int quarters = 0; quarters < kQuarters; ++quarters) {
    const Eigen::Vector2d press = turned({0.0, 1.0}, quarters);
    const Eigen::Vector2d slip = turned({-1.0, 0.0}, quarters);
    const std::string turn = ", " + std::to_string(quarters) + " quarters turned [m/s]";
    if (physics.walls) {
      for (const double wanted : {0.2, 0.4}) {  // it sticks, it slips
        WorldState start;
        start.tee_position = {0.0, 0.0};
        start.pusher_position = {0.2, p.wall_inner_face - p.pusher_radius};
        world.reset(turned(start, quarters));
        const Eigen::Vector2d begin = world.state().pusher_position;
        steps(world, 0.3 * press + wanted * slip, kSteps);
        deviations.expectNear("mean slip along a wall" + turn,
                              (world.state().pusher_position - begin).dot(slip) / (kSteps * kControlStep),
                              expected(0.3, wanted), physics.slip_speed);
        if (physics.discs || expected(0.3, wanted) > 0.1) {
          continue;  // discs have no face to slip along; the face is short
        }
        start.tee_position = {-(p.wall_inner_face - p.bar_half_length), p.wall_inner_face - p.bar_half_width};
        start.pusher_position =
            start.tee_position + Eigen::Vector2d(p.bar_half_length, -(p.bar_half_width + p.pusher_radius));
        world.reset(turned(start, quarters));
        steps(world, 0.3 * press + wanted * slip, 2);
        deviations.expectNear("slip along the bar" + turn, world.state().pusher_velocity.dot(slip),
                              expected(0.3, wanted), physics.slip_speed);
      }
    }
    if (p.contact_friction == 0.0) {
      WorldState start;
      start.pusher_position = {0.0, p.bar_half_width + p.pusher_radius};
      world.reset(turned(start, quarters));
      steps(world, -0.4 * press + 0.1 * slip, 1);
      PlainPusher alone = {0.0, 0.0};
      alone.controlStep(physics, 0.1F);
      const Eigen::Vector2d gone = world.state().pusher_position - turned(start, quarters).pusher_position;
      deviations.expectNear("slip across a tee that is pushed" + turn, gone.dot(slip), alone.position,
                            physics.contact_position);
    }
  }
  return deviations;
}

}  // namespace physics

std::vector<std::string> findingsIn(Simulator& world, const PhysicsOfKind& claims) {
  std::vector<std::string> names;
  for (const NamedPhysicsCheck& named : kPhysicsChecks) {
    if (named.check(world, claims).any()) {
      names.emplace_back(named.name);
    }
  }
  return names;
}

}  // namespace pusht::testing
