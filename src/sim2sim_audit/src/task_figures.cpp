// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_audit/task_figures.hpp"

#include <cmath>
#include <limits>

#include "experiments.hpp"
#include "pusht_task/constants.hpp"

namespace sim2sim {
namespace {

/// A world that starts where it is told, reports what there is, and acts at once.
void setContract(const pusht::Task& task, Measurements& figures) {
  for (const PropertyDescription& description : allProperties()) {
    if (isContract(description.property)) {
      figures.set(description.property, 0.0);
    }
  }
  for (const Property factor : {Property::kYawGain, Property::kPusherVelocityFactor, Property::kTeeVelocityFactor,
                                Property::kYawRateFactor, Property::kHold, Property::kAxesMirror,
                                Property::kActionScaleX, Property::kActionScaleY, Property::kSmallCommand}) {
    figures.set(factor, 1.0);
  }
  figures.set(Property::kControlStep, pusht::kControlStep);
  figures.set(Property::kActionLimit, task.action_limit.value_or(std::numeric_limits<float>::infinity()));
}

/// [s] Distance that a coasting pusher goes, over its speed, less that with a speed that falls steadily: it keeps the
/// share q of it in each substep, and moves with what is left.
double moveOrder(const pusht::Physics& physics) {
  const double rate = (physics.servo_gain + physics.pusher_damping) / physics.pusher_mass;  // [1/s]
  return 1.0 / rate - pusht::kSubstep / std::log1p(pusht::kSubstep * rate);
}

/// Masses and forces over the servo's gain, as free motions show them.
void setForces(const pusht::Physics& physics, Measurements& figures) {
  const double gain = physics.servo_gain;
  const double center = physics.centerOfMass();
  figures.set(Property::kServoGain, 1.0);
  figures.set(Property::kServoLimit, physics.servo_limit / gain);
  figures.set(Property::kPusherDamping, physics.pusher_damping / gain);
  figures.set(Property::kPusherMass, physics.pusher_mass / gain);
  figures.set(Property::kServoLag, 0.0);
  figures.set(Property::kOvershoot, 0.0);
  figures.set(Property::kMoveOrder, moveOrder(physics));
  figures.set(Property::kTeeMass, physics.tee_mass / gain);
  figures.set(Property::kCenterOfMass, center);
  figures.set(Property::kTeeMoment, (physics.tee_second_moment - physics.tee_mass * center * center) / gain);
  figures.set(Property::kTeeDamping, physics.tee_damping / gain);
  figures.set(Property::kTeeYawDamping, physics.tee_yaw_damping / gain);
  figures.set(Property::kTeeFrictionX, physics.tee_friction[0] / gain);
  figures.set(Property::kTeeFrictionY, physics.tee_friction[1] / gain);
  figures.set(Property::kTeeYawFriction, physics.tee_yaw_friction / gain);
  figures.set(Property::kFrictionShape, std::sqrt(2.0));  // a limit for each axis
  figures.set(Property::kDampingPoint, physics.table_point);
  figures.set(Property::kFrictionPoint, physics.table_point);
  figures.set(Property::kFrictionSmoothing, 0.0);
  figures.set(Property::kTeeLaw, 0.0);
}

void setShapes(const pusht::Physics& physics, Measurements& figures) {
  figures.set(Property::kOutline, 0.0);
  figures.set(Property::kPusherRadius, physics.pusher_radius);
  figures.set(Property::kBarHalfLength, physics.bar_half_length);
  figures.set(Property::kBarHalfWidth, physics.bar_half_width);
  figures.set(Property::kStemEnd, physics.stem_offset + physics.stem_half_length);
  figures.set(Property::kStemHalfWidth, physics.stem_half_width);
  figures.set(Property::kStemPlace, 0.0);
  figures.set(Property::kSlop, 0.0);
  figures.set(Property::kContactFriction, physics.contact_friction);
  for (const Property wall :
       {Property::kWallUp, Property::kWallDown, Property::kWallRight, Property::kWallLeft, Property::kTeeAtWallUp,
        Property::kTeeAtWallDown, Property::kTeeAtWallRight, Property::kTeeAtWallLeft}) {
    figures.set(wall, physics.wall_inner_face);
  }
}

}  // namespace

Measurements figuresOf(const pusht::Task& task) {
  const pusht::Physics& physics = task.physics;
  Measurements figures;
  for (const Property left_open : {Property::kOverlap, Property::kHit}) {
    figures.fail(left_open, "the task leaves it open");
  }
  setContract(task, figures);
  setForces(physics, figures);
  setShapes(physics, figures);
  return figures;
}

Audit auditAgainstTask(const AuditedWorld& world, std::uint64_t seed) {
  const auto simulator = world.make();
  Bench bench(*simulator, world.make, seed);
  Audit result =
      compare(figuresOf(bench.task()), measure(bench), {}, bench.startTolerance(), world.departures, bench.task());
  result.reference = kTaskTitle;
  result.engine = world.title;
  result.seed = seed;
  return result;
}

}  // namespace sim2sim
