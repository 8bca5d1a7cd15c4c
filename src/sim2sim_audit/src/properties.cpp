// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <stdexcept>

#include "sim2sim_audit/property.hpp"

namespace sim2sim {
namespace {

using P = Property;
using Properties = std::vector<Property>;

Properties operator+(Properties a, const Properties& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Causes of which others follow: what the experiments of a property take for granted. A cause that no planted fault
// (planted_faults_test.cpp) has shown to move a property is none of it.
const Properties kStarts = {P::kRefusedStarts,    P::kStartPusherPosition, P::kStartPusherVelocity,
                            P::kStartTeePosition, P::kStartTeeVelocity,    P::kStartYaw,
                            P::kStartYawRate};
const Properties kReports = {P::kNoise, P::kLeak, P::kStaleSteps};
const Properties kYaw = {P::kYawGain, P::kYawOffset};
const Properties kTeeVelocities = {P::kTeeVelocityFactor, P::kTeeVelocityFrame, P::kTeeVelocityPoint,
                                   P::kYawRateFactor};
const Properties kMotion = {P::kRestMotion, P::kSpeedGain};  // a command is a velocity, and no command none
const Properties kTime = kMotion + Properties{P::kControlStep, P::kDelay, P::kHold};
const Properties kDirections = {P::kAxesTurn, P::kAxesMirror};
const Properties kOrigin = {P::kOriginX, P::kOriginY};
/// Touch sets bodies at rest beside each other and commands little or nothing.
const Properties kByTouch = kStarts + kReports + kYaw + kOrigin + Properties{P::kRestMotion};
/// The pusher alone.
const Properties kOfPusher =
    kStarts + kReports + kTime + kDirections + Properties{P::kPusherVelocityFactor, P::kSmallCommand};
/// The tee alone, and under a push that is steady before it counts: physics is measured through the contract.
const Properties kOfTee = kStarts + kReports + kYaw + kTeeVelocities + kMotion + kDirections + kOrigin +
                          Properties{P::kControlStep, P::kHold, P::kPusherVelocityFactor, P::kSmallCommand};
const Properties kContract = kOfTee + Properties{P::kDelay};
const Properties kPusherForces = {P::kServoGain, P::kServoLimit, P::kPusherDamping, P::kPusherMass};
/// Numbers of a tee are those of a law, estimated from displacements, and mean little of one that moves by another.
const Properties kByLaw = kOfTee + Properties{P::kMoveOrder, P::kTeeLaw};
/// Sizes are numbers of two boxes, and mean little of a tee of other shapes.
const Properties kByOutline = kByTouch + Properties{P::kOutline};
const Properties kTeeForces = {P::kTeeMass,       P::kCenterOfMass, P::kTeeMoment,    P::kTeeDamping,
                               P::kTeeYawDamping, P::kTeeFrictionX, P::kTeeFrictionY, P::kTeeYawFriction,
                               P::kFrictionShape, P::kDampingPoint, P::kFrictionPoint};
const Properties kShapes = {P::kPusherRadius, P::kBarHalfLength, P::kBarHalfWidth,
                            P::kStemEnd,      P::kStemHalfWidth, P::kStemPlace};
const Properties kPushed = kContract + kPusherForces + kTeeForces + kShapes + Properties{P::kTeeLaw, P::kOutline};
const Properties kTeeAtWall = kByTouch + kDirections + Properties{P::kSpeedGain};

// Resolutions: what the experiments can tell. Those of the task's lengths are what its users can feel.
constexpr Resolution kExact = {0.0, 0.0, 2e-4};
constexpr Resolution kExactSpeed = {0.0, 0.0, 0.1};
constexpr Resolution kExactYaw = {0.0, 0.0, 3e-3};
constexpr Resolution kExactYawRate = {0.0, 0.0, 1.0};
constexpr Resolution kRepeated = {0.0, 0.0, 1e-5};
constexpr Resolution kEither = {0.5, 0.0, 0.01};  // one of a few whole numbers: all else depends on it
constexpr Resolution kMasses = {0.0, 0.03};
constexpr Resolution kTurning = {0.0, 0.06};
constexpr Resolution kLengths = {2e-4, 0.0};

std::vector<PropertyDescription> describeAll() {
  constexpr Area kBook = Area::kBookkeeping;
  constexpr Area kFrame = Area::kFrames;
  constexpr Area kAction = Area::kTimeAndAction;
  constexpr Area kPusher = Area::kPusher;
  constexpr Area kTee = Area::kTee;
  constexpr Area kTouch = Area::kContact;
  constexpr Area kWall = Area::kWalls;
  const Properties of_starts = {P::kRefusedStarts, P::kNoise};
  const Properties none;
  // A row is a property.
  // clang-format off
  return {
      {P::kRefusedStarts, "refused_starts", "starts refused, of 12", "", kBook, kEither, false, 0.1,
       "the reset: it must take every pose and velocity on the table", none},
      {P::kStartPusherPosition, "start_pusher_position", "start round trip, pusher position", "m", kBook, kExact,
       false, 1.0, "the reset and the report of the pusher's position", of_starts},
      {P::kStartPusherVelocity, "start_pusher_velocity", "start round trip, pusher velocity", "m/s", kBook, kExactSpeed,
       false, 0.01, "the reset and the report of the pusher's velocity",
       of_starts + Properties{P::kPusherVelocityFactor}},
      {P::kStartTeePosition, "start_tee_position", "start round trip, tee position", "m", kBook, kExact, false, 1.0,
       "the reset and the report of the tee's position", of_starts},
      {P::kStartTeeVelocity, "start_tee_velocity", "start round trip, tee velocity", "m/s", kBook, kExactSpeed, false,
       0.01, "the reset and the report of the tee's velocity",
       of_starts + Properties{P::kTeeVelocityFactor, P::kTeeVelocityFrame, P::kTeeVelocityPoint}},
      {P::kStartYaw, "start_yaw", "start round trip, yaw", "rad", kBook, kExactYaw, false, 0.1,
       "the reset and the report of the yaw", of_starts},
      {P::kStartYawRate, "start_yaw_rate", "start round trip, yaw rate", "rad/s", kBook, kExactYawRate, false, 0.001,
       "the reset and the report of the yaw rate", of_starts + Properties{P::kYawRateFactor}},
      {P::kFixedPoint, "fixed_point", "reset to the reported state", "m, rad, /s", kBook, kExact, false, 1.0,
       "state(): a reset to what it reports must change nothing", kStarts + Properties{P::kNoise}},
      {P::kNoise, "noise", "the same episode twice", "m", kBook, kRepeated, false, 0.4,
       "random numbers, threads, clocks", none},
      {P::kLeak, "leak", "the same episode after another one", "m", kBook, kRepeated, false, 0.05,
       "the reset: something of the last episode is left (commands, warm starts, contacts)", {P::kNoise}},
      {P::kSecondWorld, "second_world", "the same episode in another world", "m", kBook, kRepeated, false, 5.0,
       "global state that worlds share", {P::kNoise, P::kLeak}},
      {P::kHiddenState, "hidden_state", "one step after a reset to a state in mid-episode", "m", kBook, {5e-4}, false,
       1.0, "state that decides what comes and is not reported",
       kReports + kStarts + kTime + kYaw + kTeeVelocities + Properties{P::kFixedPoint, P::kOriginX, P::kOriginY}},
      {P::kStaleSteps, "stale_steps", "control steps by which the reported state is late", "", kBook, kEither, false,
       0.005, "what is read after a step: the state before it", {P::kNoise, P::kStartTeeVelocity, P::kRefusedStarts}},
      {P::kYawGain, "yaw_gain", "yaw by touch over yaw in the state", "", kFrame, {0.03}, false, 0.008,
       "unit and sense of the yaw", kReports + Properties{P::kStartYaw, P::kRefusedStarts}},
      {P::kYawOffset, "yaw_offset", "yaw by touch where the state says 0", "rad", kFrame, {3e-3}, false, 0.024,
       "zero of the yaw: the stem is along body -y", kReports + Properties{P::kStartYaw, P::kYawGain}},
      {P::kOriginX, "tee_origin_x", "bar's center from the tee origin, along x", "m", kFrame, kLengths, false, 0.5,
       "the point whose position is reported: the bar's center", kReports + kYaw},
      {P::kOriginY, "tee_origin_y", "bar's center from the tee origin, along y", "m", kFrame, kLengths, false, 0.5,
       "the point whose position is reported: the bar's center, not the center of mass", kReports + kYaw},
      {P::kPusherVelocityFactor, "pusher_velocity_factor", "pusher's velocity over its finite differences", "", kFrame,
       {0.02}, false, 0.001, "unit of the pusher's velocity, or what is divided by which time step",
       kReports + kMotion},
      {P::kTeeVelocityFactor, "tee_velocity_factor", "tee's velocity over its finite differences", "", kFrame, {0.03},
       false, 0.001, "unit of the tee's velocity, or what is divided by which time step",
       kReports + kYaw + kDirections + kTime},
      {P::kTeeVelocityFrame, "tee_velocity_frame", "axes of the tee's velocity (0: the table's, 1: its own, 2: others)",
       "", kFrame,
       kEither, false, 0.0002, "axes of the tee's velocity: the table's", kReports + kYaw + kDirections + kTime},
      {P::kTeeVelocityPoint, "tee_velocity_point", "point whose velocity is reported, from the tee origin", "m",
       kFrame, {3e-3}, false, 0.003, "point of the tee's velocity: the tee origin, not the center of mass",
       kReports + kYaw + kDirections + kTime + Properties{P::kTeeVelocityFrame}},
      {P::kYawRateFactor, "yaw_rate_factor", "yaw rate over finite differences of the yaw", "", kFrame, {0.03}, false,
       0.001, "unit and sense of the yaw rate", kReports + kDirections + kTime + Properties{P::kYawGain}},
      {P::kControlStep, "control_step", "length of a control step", "s", kAction, {1e-3}, false, 0.33,
       "substeps in a control step, and their length", kReports + kMotion},
      {P::kRestMotion, "rest_motion", "motion in 3 control steps of bodies at rest, without a command", "m", kAction,
       {1e-5}, false, 0.5, "an offset of the command; forces on bodies at rest", kReports},
      {P::kSpeedGain, "speed_gain", "speed gained in a control step of a constant command, after six", "", kAction,
       {0.02, 0.0, 2e-3}, false, 0.02,
       "a command that is taken for a force, or that is integrated; a servo that does not settle",
       kReports + Properties{P::kRestMotion}},
      {P::kDelay, "delay", "delay of actions", "s", kAction, {2e-3}, false, 0.05,
       "a queue or a filter between command and servo; a command that is read after the step",
       kReports + kMotion + Properties{P::kStartPusherVelocity, P::kControlStep, P::kPusherVelocityFactor}},
      {P::kHold, "hold", "how long one command lasts, in control steps", "", kAction, {0.02}, false, 0.015,
       "the command must hold for the whole control step and no longer", kReports + kMotion},
      {P::kAxesTurn, "axes_turn", "direction of the answer to a command along x", "rad", kAction, {0.01}, false, 0.016,
       "order and signs of the action's axes", kReports + kMotion},
      {P::kAxesMirror, "axes_mirror", "hand of the answer to commands (1: right, -1: mirrored)", "", kAction, kEither,
       false, 0.011, "order and signs of the action's axes", kReports + kMotion},
      {P::kActionScaleX, "action_scale_x", "scale of the action along x", "", kAction, {0.01}, false, 0.035,
       "scaling or unit of the action",
       kReports + kDirections + kTime +
           Properties{P::kSmallCommand, P::kPusherVelocityFactor, P::kStartPusherVelocity}},
      {P::kActionScaleY, "action_scale_y", "scale of the action along y", "", kAction, {0.01}, false, 0.035,
       "scaling or unit of the action",
       kReports + kDirections + kTime +
           Properties{P::kSmallCommand, P::kPusherVelocityFactor, P::kStartPusherVelocity}},
      {P::kSmallCommand, "small_command", "answer to a command of 0.02 m/s over that to 0.25 m/s, in proportion", "",
       kAction, {0.02}, false, 0.001, "a dead band of the command; Coulomb friction of the pusher",
       kReports + kDirections + kTime},
      {P::kActionLimit, "action_limit", "largest command that is followed", "m/s", kAction, {0.01}, false, 0.001,
       "clipping of the action", kReports + kDirections + kTime},
      {P::kServoGain, "servo_gain", "servo gain", "N s/m", kPusher, kMasses, true, 0.011, "gain of the velocity servo",
       kOfPusher},
      {P::kServoLimit, "servo_limit", "servo force limit", "N", kPusher, kMasses, true, 2e-05,
       "force limit of the servo", kOfPusher},
      {P::kPusherDamping, "pusher_damping", "pusher damping", "N s/m", kPusher, {0.0, 0.1}, true, 0.003,
       "damping of the pusher; steady error of its servo", kOfPusher},
      {P::kPusherMass, "pusher_mass", "pusher mass", "kg", kPusher, kMasses, true, 0.003,
       "mass of the pusher; the time in which its servo settles", kOfPusher + Properties{P::kMoveOrder}},
      {P::kServoLag, "servo_lag", "time by which the servo's force is late", "s", kPusher, {1e-4, 0.0, 1e-3}, false,
       0.1, "integrator of the servo: force at the velocity at a substep's end (implicit), or begin (explicit)",
       kOfPusher + Properties{P::kMoveOrder}},
      {P::kOvershoot, "overshoot", "overshoot of the pusher", "", kPusher, {0.01}, false, 0.01,
       "integral part or underdamping of the servo", kOfPusher + kPusherForces},
      {P::kMoveOrder, "move_order", "time by which a coasting pusher's way is ahead of its velocities", "s", kPusher,
       {5e-3, 0.0, 1e-4}, false, 0.14, "order in a substep: velocities change first, then bodies move with them",
       kOfPusher},
      {P::kTeeMass, "tee_mass", "tee mass", "kg", kTee, kMasses, true, 0.0013, "mass of the tee", kByLaw},
      {P::kCenterOfMass, "center_of_mass", "center of mass, from the tee origin along -y", "m", kTee, {1e-3}, false,
       0.025, "center of mass of the tee; masses of bar and stem", kByLaw},
      {P::kTeeMoment, "tee_moment", "moment of inertia about the center of mass", "kg m^2", kTee, kTurning, true,
       0.001, "moment of inertia: about which point, with the offset of the stem", kByLaw},
      {P::kTeeDamping, "tee_damping", "damping of the tee", "N s/m", kTee, kMasses, true, 0.006,
       "viscous friction of the tee with the table", kByLaw},
      {P::kTeeYawDamping, "tee_yaw_damping", "damping of the tee's yaw", "N m s", kTee, kTurning, true, 0.005,
       "viscous friction of the yaw", kByLaw},
      {P::kTeeFrictionX, "tee_friction_x", "Coulomb friction of the tee along x", "N", kTee, kMasses, true, 0.006,
       "Coulomb friction of the tee with the table", kByLaw},
      {P::kTeeFrictionY, "tee_friction_y", "Coulomb friction of the tee along y", "N", kTee, kMasses, true, 0.006,
       "Coulomb friction of the tee with the table", kByLaw},
      {P::kTeeYawFriction, "tee_yaw_friction", "Coulomb friction of the tee's yaw", "N m", kTee, kTurning, true,
       0.0007, "Coulomb friction of the yaw", kByLaw},
      {P::kFrictionShape, "friction_shape", "Coulomb friction at 45 degrees over that along an axis", "", kTee, {0.03},
       false, 0.009, "a limit for each axis (1.41) or one for all directions (1.00)", kByLaw},
      {P::kDampingPoint, "damping_point", "point on which the damping acts, from the tee origin", "m", kTee, {3e-3},
       false, 0.1, "point of the damping: the tee origin or the center of mass",
       kByLaw + Properties{P::kCenterOfMass}},
      {P::kFrictionPoint, "friction_point", "point on which the Coulomb friction acts, from the tee origin", "m", kTee,
       {3e-3}, false, 0.1, "point of the friction: the tee origin or the center of mass",
       kByLaw + Properties{P::kCenterOfMass}},
      {P::kFrictionSmoothing, "friction_smoothing", "speed below which Coulomb friction of the tee fades", "m/s", kTee,
       {5e-3}, false, 0.025, "a smooth function (tanh) in place of the sign of the velocity",
       kOfTee + Properties{P::kMoveOrder}},
      {P::kTeeLaw, "tee_law", "what the audit's laws do not explain of a free tee's motion", "m", kTee,
       {1.5e-4, 0.0, 1e-5}, false, 1.0,
       "laws of friction and damping: linear damping, Coulomb friction, sharp or smoothed",
       kOfTee + Properties{P::kMoveOrder}},
      {P::kOutline, "outline", "departure of the tee's outline from two boxes", "m", kTouch, {5e-4}, false, 0.2,
       "shapes of the tee: two boxes", kByTouch},
      {P::kPusherRadius, "pusher_radius", "pusher radius", "m", kTouch, kLengths, false, 0.7,
       "radius of the pusher; a margin or a skin around bodies", kByOutline},
      {P::kBarHalfLength, "bar_half_length", "half-length of the bar", "m", kTouch, kLengths, false, 0.17,
       "size of the bar's box", kByOutline},
      {P::kBarHalfWidth, "bar_half_width", "half-width of the bar", "m", kTouch, kLengths, false, 0.7,
       "size of the bar's box", kByOutline},
      {P::kStemEnd, "stem_end", "end of the stem, from the bar's center", "m", kTouch, kLengths, false, 0.07,
       "offset or length of the stem's box, which touch cannot tell apart", kByOutline},
      {P::kStemHalfWidth, "stem_half_width", "half-width of the stem", "m", kTouch, kLengths, false, 0.2,
       "size of the stem's box", kByOutline},
      {P::kStemPlace, "stem_place", "middle of the stem, from the bar's", "m", kTouch, kLengths, false, 0.2,
       "place of the stem's box", kByOutline},
      {P::kSlop, "slop", "least overlap that is pushed apart", "m", kTouch, kLengths, false, 0.07,
       "overlap that the solver leaves alone: slop, allowed penetration", kByTouch + kTime + kDirections},
      {P::kContactFriction, "contact_friction", "friction between the bodies", "", kTouch, {0.05}, false, 0.004,
       "coefficient of friction of contacts, and how two of them are combined", kContract},
      {P::kOverlap, "overlap", "overlap in a steady push", "m", kTouch, {3e-4}, false, 1.0, "softness of contacts",
       kPushed},
      {P::kHit, "hit", "how far a tee rebounds from the pusher", "m", kTouch, {1e-3}, false, 0.1,
       "restitution of contacts",
       kPushed},
      {P::kWallUp, "wall_up", "wall towards +y, for the pusher", "m", kWall, {5e-4}, false, 1e-05, "place of the wall",
       kByTouch},
      {P::kWallDown, "wall_down", "wall towards -y, for the pusher", "m", kWall, {5e-4}, false, 1e-05,
       "place of the wall", kByTouch},
      {P::kWallRight, "wall_right", "wall towards +x, for the pusher", "m", kWall, {5e-4}, false, 1e-05,
       "place of the wall", kByTouch},
      {P::kWallLeft, "wall_left", "wall towards -x, for the pusher", "m", kWall, {5e-4}, false, 1e-05,
       "place of the wall", kByTouch},
      {P::kTeeAtWallUp, "tee_wall_up", "wall towards +y, for the tee", "m", kWall, {1.5e-3}, false, 1e-05,
       "collisions of tee and wall",
       kTeeAtWall + Properties{P::kWallUp}},
      {P::kTeeAtWallDown, "tee_wall_down", "wall towards -y, for the tee", "m", kWall, {1.5e-3}, false, 1e-05,
       "collisions of tee and wall",
       kTeeAtWall + Properties{P::kWallDown}},
      {P::kTeeAtWallRight, "tee_wall_right", "wall towards +x, for the tee", "m", kWall, {1.5e-3}, false, 1e-05,
       "collisions of tee and wall",
       kTeeAtWall + Properties{P::kWallRight}},
      {P::kTeeAtWallLeft, "tee_wall_left", "wall towards -x, for the tee", "m", kWall, {1.5e-3}, false, 1e-05,
       "collisions of tee and wall",
       kTeeAtWall + Properties{P::kWallLeft}},
  };
  // clang-format on
}

}  // namespace

const char* nameOfInfinity(Property property) { return property == P::kServoGain ? "unlimited" : "none"; }

const char* nameOf(Area area) {
  switch (area) {
    case Area::kBookkeeping:
      return "bookkeeping";
    case Area::kFrames:
      return "frames and units";
    case Area::kTimeAndAction:
      return "time and action";
    case Area::kPusher:
      return "pusher";
    case Area::kTee:
      return "tee";
    case Area::kContact:
      return "contact";
    case Area::kWalls:
      return "walls";
  }
  return "";
}

const std::vector<PropertyDescription>& allProperties() {
  static const std::vector<PropertyDescription> all = describeAll();
  return all;
}

const PropertyDescription& describe(Property property) {
  return allProperties().at(static_cast<std::size_t>(property));
}

}  // namespace sim2sim
