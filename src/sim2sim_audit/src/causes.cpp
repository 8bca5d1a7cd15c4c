// SPDX-License-Identifier: BSD-3-Clause
// Likely causes of findings, in words.
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/physics.hpp"
#include "sim2sim_audit/audit.hpp"
#include "sim2sim_audit/task_figures.hpp"

namespace sim2sim {
namespace {

std::string number(double value, int digits = 3) {
  return std::isfinite(value) ? pusht::significantText(value, digits) : "none";
}

bool isNear(double value, double expected, double tolerance) { return std::abs(value - expected) <= tolerance; }

/// "1 control step", "2 control steps".
std::string steps(double count) {
  const std::string text = number(std::round(100.0 * count) / 100.0);
  return text + (text == "1" ? " control step" : " control steps");
}

std::string causeOfDelay(double seconds) {
  const double count = seconds / pusht::kControlStep;
  if (count < 0.0) {
    return "acts " + steps(-count) + " early: something of the command is taken before its time";
  }
  return "acts " + steps(count) + " late: " + number(seconds) + " s between a command and the first motion";
}

std::string causeOfYawGain(double gain) {
  if (isNear(gain, pusht::kPi / 180.0, 2e-3)) {
    return "the yaw is in degrees: a yaw of 1 turns the tee by a degree";
  }
  if (isNear(gain, -1.0, 0.05)) {
    return "the yaw has the other sense: positive turns are clockwise";
  }
  return "a yaw of 1 rad turns the tee by " + number(gain) + " rad";
}

std::string causeOfOrigin(double from_bar) {
  const double center = pusht::Physics().centerOfMass();
  if (isNear(from_bar, center, 1e-3)) {
    return "the tee's position is that of its center of mass, " + number(1e3 * center) + " mm from the bar's center";
  }
  return "the tee's position is that of a point " + number(-1e3 * from_bar) + " mm from the bar's center along body y";
}

std::string causeOfVelocityPoint(double point) {
  const double center = pusht::Physics().centerOfMass();
  if (isNear(point, center, 4e-3)) {
    return "the tee's velocity is that of its center of mass";
  }
  return "the tee's velocity is that of a point " + number(1e3 * point) + " mm from the tee origin along body -y";
}

std::string causeOfVelocityFactor(const std::string& whose, double factor) {
  return whose + " velocity is " + number(factor) + " times what the positions say";
}

std::string causeOfControlStep(double seconds) {
  const double substeps = seconds / pusht::kSubstep;
  std::string text = "a control step is " + number(seconds) + " s long";
  if (isNear(substeps, std::round(substeps), 0.05)) {
    text += ": " + number(std::round(substeps)) + " substeps of 0.01 s, or shorter ones";
  }
  return text;
}

std::string causeOfTurn(double angle) {
  if (isNear(std::abs(angle), pusht::kPi, 0.05)) {
    return "a command along +x moves the pusher along -x";
  }
  if (isNear(std::abs(angle), 0.5 * pusht::kPi, 0.05)) {
    return "a command along +x moves the pusher along " + std::string(angle > 0.0 ? "+y" : "-y") +
           ": axes swapped or turned";
  }
  return "a command along +x moves the pusher at " + number(angle) + " rad from it";
}

std::string causeOfMirror(double hand) {
  return hand < 0.0 ? "the action's axes are mirrored: one has the other sign, or they are swapped"
                    : "the reference's action axes are mirrored";
}

/// "tee mass is 1.2 times the reference's": of a number that has a zero.
std::string ratio(const Comparison& finding) {
  const std::string title = describe(finding.property).title;
  const double reference = *finding.reference;
  const double engine = *finding.engine;
  const bool is_none = std::abs(engine) < 1e-3 * std::abs(reference);
  if (!std::isfinite(engine) || is_none) {
    return title + ": there is none";
  }
  if (!std::isfinite(reference) || reference == 0.0) {
    return title + ": there is one, the reference has none";
  }
  return title + " is " + number(engine / reference) + " times the reference's";
}

std::string difference(const Comparison& finding) {
  const PropertyDescription& description = describe(finding.property);
  if (!std::isfinite(*finding.engine)) {
    return std::string(description.title) + ": there is none";
  }
  if (!std::isfinite(*finding.reference)) {
    return std::string(description.title) + ": there is one, the reference has none";
  }
  const bool is_length = std::string(description.unit) == "m";
  const double shown = is_length ? 1e3 * finding.difference() : finding.difference();
  return std::string(description.title) + " is off by " + number(shown) +
         (is_length ? " mm" : std::string(" ") + description.unit);
}

std::string causeOfServoGain(const Comparison& finding) {
  const std::string stiff = "moves as commanded, whatever it pushes: a motor as stiff as its limit allows";
  if (!std::isfinite(*finding.engine)) {
    return "the pusher " + stiff + ", not a soft servo";
  }
  return std::isfinite(*finding.reference) ? ratio(finding) : "the reference's pusher " + stiff;
}

std::string causeOfMoveOrder(const Comparison& finding) {
  const bool ahead = *finding.engine > 0.0;
  if (ahead == (*finding.reference > 0.0)) {
    return difference(finding);
  }
  return ahead ? "bodies move with the velocities of a substep's begin: before collisions are solved, not after"
               : "bodies move with the velocities of a substep's end: after collisions are solved, not before";
}

std::string causeOfServoLag(double seconds) {
  return "the servo is explicit: its force is that of the velocity " + number(1e3 * seconds) +
         " ms ago, at a substep's begin. A free pusher moves as one with less mass";
}

std::string causeOfSmoothing(double speed) {
  return speed > 0.0 ? "Coulomb friction of the tee is smoothed: it fades below " + number(speed) +
                           " m/s, as by tanh, and holds nothing at rest"
                     : "Coulomb friction of the tee is sharp, not smoothed";
}

std::string causeOfTeeLaw(const Comparison& finding) {
  const bool in_engine = *finding.engine > *finding.reference;
  return std::string(in_engine ? "a free tee" : "the reference's free tee") +
         " moves by none of the audit's laws: the best fit is off by " +
         number(1e3 * (in_engine ? *finding.engine : *finding.reference)) +
         " mm (root mean square), and its masses and frictions are numbers of a poor fit";
}

std::string causeOfOutline(const Comparison& finding) {
  const bool in_engine = *finding.engine > *finding.reference;
  return std::string(in_engine ? "the tee is" : "the reference's tee is") +
         " not two boxes: a face that is to be flat is round or slanted by " +
         number(1e3 * (in_engine ? *finding.engine : *finding.reference)) + " mm, so that it has no sizes of boxes";
}

std::string causeOfSlop(double least) {
  return std::isfinite(least) ? "bodies that overlap by up to " + number(1e3 * least) + " mm are left alone"
                              : "bodies that overlap are not pushed apart";
}

/// Cause of what the engine does.
std::string causeInEngine(const Comparison& finding) {
  const double engine = *finding.engine;
  switch (finding.property) {
    case Property::kDelay:
      return causeOfDelay(engine);
    case Property::kYawGain:
      return causeOfYawGain(engine);
    case Property::kYawOffset:
      return "the yaw is off by " + number(engine) + " rad";
    case Property::kOriginY:
      return causeOfOrigin(engine);
    case Property::kTeeVelocityPoint:
      return causeOfVelocityPoint(engine);
    case Property::kPusherVelocityFactor:
      return causeOfVelocityFactor("the pusher's", engine);
    case Property::kTeeVelocityFactor:
      return causeOfVelocityFactor("the tee's", engine);
    case Property::kYawRateFactor:
      return "the yaw rate is " + number(engine) + " times what the yaws say";
    case Property::kTeeVelocityFrame:
      return isNear(engine, 1.0, 0.5) ? "the tee's velocity is in its own axes, not in the table's"
                                      : "the tee's velocity is in axes that are neither the table's nor its own";
    case Property::kControlStep:
      return causeOfControlStep(engine);
    case Property::kHold:
      return "one command lasts " + steps(engine);
    case Property::kAxesTurn:
      return causeOfTurn(engine);
    case Property::kAxesMirror:
      return causeOfMirror(engine);
    case Property::kActionScaleX:
      return "a command along x counts " + number(engine) + " times";
    case Property::kActionScaleY:
      return "a command along y counts " + number(engine) + " times";
    case Property::kRestMotion:
      return "bodies at rest move by " + number(1e3 * engine) + " mm without a command";
    case Property::kSpeedGain:
      return "a constant command does not give a constant speed: " + number(100.0 * engine) + " % more in each step";
    case Property::kSmallCommand:
      return "a small command counts " + number(engine) + " times, compared with a large one";
    case Property::kActionLimit:
      return "commands above " + number(engine) + " m/s are clipped";
    case Property::kStaleSteps:
      return "the reported state is " + steps(engine) + " old";
    case Property::kNoise:
      return "two equal episodes differ by " + number(engine) + " m: noise";
    case Property::kLeak:
      return "an episode depends on the one before: " + number(engine) + " m";
    case Property::kSecondWorld:
      return "two worlds of one model differ by " + number(engine) + " m";
    case Property::kHiddenState:
      return "a reset to a state that was just reported changes the next step by " + number(engine) + " m";
    case Property::kRefusedStarts:
      return number(engine) + " of 12 starts are refused";
    case Property::kFixedPoint:
      return "a reset to the reported state changes it by " + number(engine);
    case Property::kFrictionShape:
      return engine < 1.2 ? "Coulomb friction has one limit in all directions (a disc), not one along each axis"
                          : "Coulomb friction has a limit along each axis (a box), not one in all directions";
    case Property::kContactFriction:
      return ratio(finding);
    case Property::kServoGain:
      return causeOfServoGain(finding);
    case Property::kMoveOrder:
      return causeOfMoveOrder(finding);
    case Property::kServoLag:
      return engine > 0.0 ? causeOfServoLag(engine) : "the servo is implicit, the reference's is explicit";
    case Property::kFrictionSmoothing:
      return causeOfSmoothing(engine);
    case Property::kTeeLaw:
      return causeOfTeeLaw(finding);
    case Property::kOutline:
      return causeOfOutline(finding);
    case Property::kSlop:
      return causeOfSlop(engine);
    default:
      break;
  }
  return describe(finding.property).mass_like ? ratio(finding) : difference(finding);
}

/// Whether the reference has the error and the engine does as the task says.
bool isOfReference(const Comparison& finding) {
  const std::optional<double> task = figuresOf({})[finding.property].value;
  return isContract(finding.property) && task &&
         std::abs(*finding.engine - *task) < std::abs(*finding.reference - *task);
}

}  // namespace

std::string causeOf(const Comparison& finding) {
  if (!isOfReference(finding)) {
    return causeInEngine(finding);
  }
  Comparison swapped = finding;
  std::swap(swapped.reference, swapped.engine);
  return "in the reference: " + causeInEngine(swapped);
}

}  // namespace sim2sim
