// SPDX-License-Identifier: BSD-3-Clause
// Shapes by touch, and what contacts do under a push.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

#include "experiments.hpp"
#include "force_sensor.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/physics.hpp"

namespace sim2sim {
namespace {

using pusht::WorldState;

WorldState teeAtYawZero(const Bench& bench) {
  WorldState scene;
  scene.tee_position = bench.shift();
  return scene;
}

// [m] Below the nominal touch: one body inside the other, and less deep than MuJoCo's bodies are above each other (30.2
// mm), which would be pushed apart up and down, where they cannot move.
constexpr double kDeep = 0.029;

/// Approach to the tee from `outward` (body frame), `beside` its origin, to a touch that is to be at `nominal` [m].
Approach approachTo(const Bench& bench, const Eigen::Vector2d& beside, const Eigen::Vector2d& outward, double nominal) {
  constexpr double kClear = 0.1;  // [m] beyond it, and beyond a collision margin of 0.04 m
  const WorldState scene = teeAtYawZero(bench);
  return {scene, scene.tee_position + beside, outward, nominal - kDeep, nominal + kClear};
}

/// Throws std::runtime_error if there is none: says where the pusher was.
double needTouch(const std::optional<double>& distance, const Approach& approach) {
  if (!distance) {
    const auto millimeters = [](double length) { return pusht::significantText(1e3 * length, 3); };
    const Eigen::Vector2d deepest =
        approach.center + approach.overlapping * approach.outward - approach.scene.tee_position;
    throw std::runtime_error("the tee is not touched with the pusher's center at (" + millimeters(deepest.x()) + ", " +
                             millimeters(deepest.y()) + ") mm in its axes, where it is " + millimeters(kDeep) +
                             " mm deep in the task's tee");
  }
  return *distance;
}

/// [m] Distance from the tee origin along `outward`, plus `beside` across it, at which the tee is touched.
double surfaceAt(Bench& bench, const Eigen::Vector2d& beside, const Eigen::Vector2d& outward, double nominal) {
  const Approach approach = approachTo(bench, beside, outward, nominal);
  return needTouch(touchDistance(bench, approach), approach);
}

/// Face of a box: where the pusher touches it at several places. A flat one is touched at the same distance.
struct Face {
  Eigen::Vector2d outward;
  double nominal;                       ///< [m] distance of the touch from the origin
  std::vector<Eigen::Vector2d> places;  ///< [m] from the origin, across `outward`
};

/// [m] Largest difference of the distances at which the pusher touches a face.
double unevenness(Bench& bench, const Face& face) {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -least;
  for (const Eigen::Vector2d& place : face.places) {
    const double distance = surfaceAt(bench, place, face.outward, face.nominal);
    least = std::min(least, distance);
    greatest = std::max(greatest, distance);
  }
  return greatest - least;
}

/// Overlap that bodies at rest keep, at the bar's end: where a pusher is held, less where it is pushed away.
void overlapLeftAlone(Bench& bench, Measurements& found) {
  const pusht::Physics& task = bench.physics();
  const Approach approach = approachTo(bench, {0.0, 0.0}, {1.0, 0.0}, task.bar_half_length + task.pusher_radius);
  const double held = needTouch(heldDistance(bench, approach), approach);
  const std::optional<double> pushed = pushedDistance(bench, approach);
  found.set(Property::kSlop, pushed ? held - *pushed : std::numeric_limits<double>::infinity());
}

/// Radius of the pusher from the corner of the bar: on the diagonal a round pusher comes nearer than it comes to the
/// faces. `end` and `back` are the distances at which it touches these [m].
double radiusByCorner(Bench& bench, double end, double back) {
  constexpr double kInside = 0.028;  // [m]
  const double diagonal = std::sqrt(0.5);
  const WorldState scene = teeAtYawZero(bench);
  const Eigen::Vector2d inside = scene.tee_position + Eigen::Vector2d(end - kInside, back - kInside);
  const auto distance = touchDistance(bench, {scene, inside, {diagonal, diagonal}, 0.0, 2.0 * kInside});
  if (!distance) {
    throw std::runtime_error("the bar's corner is not touched with the pusher's center " +
                             pusht::significantText(1e3 * kInside, 3) + " mm inside of where it touches both faces");
  }
  const double cut = kInside - *distance * diagonal;  // [m] from the square corner, along each axis
  return cut / (1.0 - diagonal);
}

constexpr double kAside = 0.045;  // [m] along the bar, clear of the stem

/// [m] Place beside the stem, along body y: clear of its end, also of a shorter one than the task's. `end` is where the
/// pusher touches that, from the origin [m].
double besideTheStem(const Bench& bench, double end) {
  constexpr double kOfTask = -0.08;
  constexpr double kFromEnd = 0.024;  // [m] a little less than the task's place is from its end
  return std::max(kOfTask, kFromEnd - (end - bench.physics().pusher_radius));
}

/// Sizes and places of bar, stem and pusher, by touching each face and a corner.
void shapes(Bench& bench, Measurements& found) {
  const pusht::Physics& task = bench.physics();
  const double radius = task.pusher_radius;
  const double right = surfaceAt(bench, {0.0, 0.0}, {1.0, 0.0}, task.bar_half_length + radius);
  const double left = surfaceAt(bench, {0.0, 0.0}, {-1.0, 0.0}, task.bar_half_length + radius);
  const double origin_x = 0.5 * (right - left);
  found.set(Property::kOriginX, origin_x);
  const double end = surfaceAt(bench, {0.0, 0.0}, {0.0, -1.0}, task.stem_offset + task.stem_half_length + radius);
  const double along_stem = besideTheStem(bench, end);
  const double back = surfaceAt(bench, {kAside, 0.0}, {0.0, 1.0}, task.bar_half_width + radius);
  const double found_radius = radiusByCorner(bench, right, back);
  found.set(Property::kPusherRadius, found_radius);
  found.set(Property::kBarHalfLength, 0.5 * (right + left) - found_radius);
  // Bodies that touch from afar leave no way into the notch between bar and stem.
  const double front = surfaceAt(bench, {kAside, 0.0}, {0.0, -1.0}, task.bar_half_width + radius);
  const double origin_y = 0.5 * (back - front);
  found.set(Property::kOriginY, origin_y);
  found.set(Property::kBarHalfWidth, 0.5 * (back + front) - found_radius);
  found.set(Property::kStemEnd, end + origin_y - found_radius);
  const double stem_right = surfaceAt(bench, {0.0, along_stem}, {1.0, 0.0}, task.stem_half_width + radius);
  const double stem_left = surfaceAt(bench, {0.0, along_stem}, {-1.0, 0.0}, task.stem_half_width + radius);
  found.set(Property::kStemHalfWidth, 0.5 * (stem_right + stem_left) - found_radius);
  found.set(Property::kStemPlace, 0.5 * (stem_right - stem_left) - origin_x);
}

/// Whether the tee is two boxes: flat at the back, at the ends of the bar, beside the stem and at its end.
void outline(Bench& bench, Measurements& found) {
  const pusht::Physics& task = bench.physics();
  const double radius = task.pusher_radius;
  const double stem_end = task.stem_offset + task.stem_half_length;
  const double along_stem = besideTheStem(bench, found.need(Property::kStemEnd) + found.need(Property::kPusherRadius));
  const double up_the_stem = 0.75 * along_stem;
  double departure = 0.0;
  for (const Face& face : {Face{{0.0, 1.0}, task.bar_half_width + radius, {{-kAside, 0.0}, {0.0, 0.0}, {kAside, 0.0}}},
                           Face{{1.0, 0.0}, task.bar_half_length + radius, {{0.0, 0.008}, {0.0, 0.0}}},
                           Face{{1.0, 0.0}, task.stem_half_width + radius, {{0.0, up_the_stem}, {0.0, along_stem}}},
                           Face{{0.0, -1.0}, stem_end + radius, {{-0.01, 0.0}, {0.0, 0.0}, {0.01, 0.0}}}}) {
    departure = std::max(departure, unevenness(bench, face));
  }
  found.set(Property::kOutline, departure);
}

/// The pusher behind the stem's end, in touch; a push along +y goes straight through the center of mass.
WorldState behindTheStem(const Bench& bench, const Measurements& found) {
  WorldState start = teeAtYawZero(bench);
  start.tee_position.y() -= 0.1;
  const double reach = found.need(Property::kStemEnd) - found.need(Property::kOriginY);
  start.pusher_position = start.tee_position +
                          Eigen::Vector2d(found.need(Property::kOriginX), -reach - found.need(Property::kPusherRadius));
  return start;
}

/// Overlap in a steady push.
void overlap(Bench& bench, Measurements& found) {
  const WorldState start = behindTheStem(bench, found);
  const double touching = (start.tee_position - start.pusher_position).norm();
  const auto states = bench.run(start, std::vector<Eigen::Vector2d>(4, {0.0, 0.6}));
  found.set(Property::kOverlap, touching - (states.back().tee_position - states.back().pusher_position).norm());
}

/// How far a tee that is thrown at a pusher rebounds from it.
void hit(Bench& bench, Measurements& found) {
  constexpr double kGap = 0.001;  // [m]
  constexpr double kSpeed = 0.5;  // [m/s] so slow that bodies are not deep in each other after a substep
  WorldState start = behindTheStem(bench, found);
  const double touching = (start.tee_position - start.pusher_position).norm();
  start.tee_position.y() += kGap;
  start.tee_velocity = {0.0, -kSpeed};
  const WorldState end = bench.run(start, {{0.0, 0.0}}).back();
  found.set(Property::kHit, (end.tee_position - end.pusher_position).norm() - touching);
}

/// Where along the bar's back a push begins, and what it did.
struct SlippingPush {
  double slip;              ///< [m] along the bar, of the pusher
  Eigen::Vector2d impulse;  ///< that the contact took, in the axes of the bar, in one unit or the other
};

/// [m/s] Impulse of a contact on the tee over its mass, by its momentum and the damping of a free tee.
Eigen::Vector2d impulseOnTee(const Bench& bench, const Measurements& found, const WorldState& from,
                             const WorldState& to) {
  const double damping = found.need(Property::kTeeDamping) * bench.physics().servo_gain / bench.physics().tee_mass;
  const WorldState begin = pusht::atPointOfTee(from, found.need(Property::kCenterOfMass));
  const WorldState end = pusht::atPointOfTee(to, found.need(Property::kCenterOfMass));
  return end.tee_velocity - begin.tee_velocity + damping * (end.tee_position - begin.tee_position);
}

/// The pusher pushes the back of the bar from `from` [m] along it, and slips.
SlippingPush slippingPush(Bench& bench, const Measurements& found, double from) {
  const pusht::Physics& task = bench.physics();
  WorldState start = teeAtYawZero(bench);
  const double back = surfaceAt(bench, {from, 0.0}, {0.0, 1.0}, task.bar_half_width + task.pusher_radius);
  start.pusher_position = start.tee_position + Eigen::Vector2d(from, back);
  // A drive to a position pushes hardest at the begin of a step: slow pushes hardly turn the tee meanwhile.
  const Eigen::Vector2d command = (bench.commandsVelocities() ? 1.0 : 0.1) * Eigen::Vector2d(0.75, -0.3);
  const auto states = bench.run(start, {command});
  const Eigen::Rotation2Dd to_body(-states[1].tee_yaw);
  const double to = (to_body * (states[1].pusher_position - states[1].tee_position)).x();
  const Eigen::Vector2d impulse = bench.commandsVelocities() ? ForceSensor(found).impulse(states[0], states[1], command)
                                                             : impulseOnTee(bench, found, states[0], states[1]);
  return {to - from, Eigen::Rotation2Dd(-0.5 * states[1].tee_yaw) * impulse};
}

/// Friction over normal force of a pusher that slips along the bar's back, by the servo as force sensor. It begins as
/// far on one side of the middle as it ends on the other, so that a round back counts even.
void contactFriction(Bench& bench, Measurements& found) {
  constexpr int kRefinements = 4;
  double from = 0.0;
  for (int i = 0; i < kRefinements; ++i) {
    from = -0.5 * slippingPush(bench, found, from).slip;
  }
  const Eigen::Vector2d impulse = slippingPush(bench, found, from).impulse;
  if (!(impulse.y() < 0.0)) {
    throw std::runtime_error("the pusher does not feel the tee");
  }
  found.set(Property::kContactFriction, impulse.x() / -impulse.y());
}

/// Whether a pusher gives way to a tee that is thrown at it. With actions that are positions no force of it can be
/// told, but for one that does not give way at all.
void yielding(Bench& bench, Measurements& found) {
  if (bench.commandsVelocities()) {
    return;  // the servo has told its mass
  }
  constexpr double kGap = 0.001;   // [m]
  constexpr double kLeast = 1e-5;  // [m]
  WorldState start = behindTheStem(bench, found);
  start.tee_position.y() += kGap;
  start.tee_velocity = {0.0, -1.0};
  const WorldState end = bench.run(start, {{0.0, 0.0}}).back();
  if ((end.pusher_position - start.pusher_position).norm() > kLeast) {
    throw std::runtime_error("actions of the task are positions, which show no force");
  }
  found.set(Property::kPusherMass, std::numeric_limits<double>::infinity());
}

}  // namespace

std::vector<Experiment> shapeExperiments() {
  return {{"shapes by touch",
           {Property::kOriginX, Property::kOriginY, Property::kPusherRadius, Property::kBarHalfLength,
            Property::kBarHalfWidth, Property::kStemEnd, Property::kStemHalfWidth, Property::kStemPlace},
           shapes},
          {"outline", {Property::kOutline}, outline},
          {"overlap left alone", {Property::kSlop}, overlapLeftAlone}};
}

std::vector<Experiment> contactExperiments() {
  return {{"steady push", {Property::kOverlap}, overlap},
          {"hit", {Property::kHit}, hit},
          {"friction", {Property::kContactFriction}, contactFriction},
          {"yielding", {Property::kPusherMass}, yielding}};
}

}  // namespace sim2sim
