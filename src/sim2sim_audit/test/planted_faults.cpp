// SPDX-License-Identifier: BSD-3-Clause
#include "planted_faults.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "chipmunk_with.hpp"
#include "coordinates.hpp"
#include "experiments.hpp"
#include "mujoco_with.hpp"
#include "pusht_task/physics.hpp"
#include "rigid_body_with.hpp"

namespace sim2sim::testing {
namespace {

using P = Property;

/// [-] Moment about the center of mass of a tee whose stem is taken to be at the origin, over the task's.
double momentWithoutOffset() {
  const Physics task;
  const double of_offset = task.tee_mass * task.centerOfMass() * task.centerOfMass();
  const double forgotten = pusht::kStemMass * pusht::kStemOffset * pusht::kStemOffset;
  return (task.tee_second_moment - forgotten - of_offset) / (task.tee_second_moment - of_offset);
}

std::vector<PlantedFault> timeFaults() {
  std::vector<PlantedFault> faults;
  for (const int substeps : {8, 9}) {
    faults.push_back({std::to_string(substeps) + " substeps: a control step of 0.0" + std::to_string(substeps) + " s",
                      {P::kControlStep},
                      [=] { return std::make_unique<MujocoOfSubsteps>(substeps); },
                      [=] { return std::make_unique<ChipmunkOfSubsteps>(substeps); },
                      rigidWith([](RigidModel&) {}, substeps)});
  }
  faults.push_back({"command held for 5 of 10 substeps",
                    {P::kHold},
                    [] { return std::make_unique<MujocoOfSubsteps>(10, 5); },
                    [] { return std::make_unique<ChipmunkOfSubsteps>(10, 5); },
                    {}});
  return faults;
}

std::vector<PlantedFault> pusherFaults() {
  using pusht::kPusherX;
  using pusht::kPusherY;
  return {
      {"servo gain times 0.7",
       {P::kServoGain},
       mujocoWith(scaledGain(0.7)),
       chipmunkWith(scaled(&Physics::servo_gain, 0.7)),
       rigidWith(rigidServo(0.7, 1.0))},
      {"servo gain times 1.2",
       {P::kServoGain},
       mujocoWith(scaledGain(1.2)),
       chipmunkWith(scaled(&Physics::servo_gain, 1.2)),
       rigidWith(rigidServo(1.2, 1.0))},
      {"servo damping times 4",
       {P::kPusherDamping},
       mujocoWith(scaledDamping({kPusherX, kPusherY}, 4.0)),
       chipmunkWith(scaled(&Physics::pusher_damping, 4.0)),
       rigidWith(rigidServo(1.0, 4.0))},
      {"servo limit times 0.7",
       {P::kServoLimit},
       mujocoWith(scaledLimit(0.7)),
       chipmunkWith(scaled(&Physics::servo_limit, 0.7)),
       rigidWith(scaled(&RigidModel::servo_limit, 0.7))},
      {"a force in place of a servo: 20 N per unit",
       {P::kSpeedGain},
       mujocoWith([](mjModel& model) {
         for (int actuator = 0; actuator < model.nu; ++actuator) {
           model.actuator_biasprm[mjNBIAS * actuator + 2] = 0.0;
         }
       }),
       {},
       {}},
      {"Coulomb friction of the pusher, 1 N",
       {P::kSmallCommand},
       mujocoWith([](mjModel& model) {
         model.dof_frictionloss[kPusherX] = 1.0;
         model.dof_frictionloss[kPusherY] = 1.0;
       }),
       {},
       {}},
      {"pusher mass times 1.5",
       {P::kPusherMass},
       mujocoWith(scaledMass("pusher", 1.5, true)),
       chipmunkWith(scaled(&Physics::pusher_mass, 1.5)),
       rigidWith(scaled(&RigidModel::pusher_mass, 1.5))},
      {"a motor as stiff as 30 N allow", {P::kServoGain}, {}, chipmunkWithout(&pusht::ChipmunkParameters::servo), {}},
      {"bodies move before their velocities change",
       {P::kMoveOrder},
       {},
       chipmunkWithout(&pusht::ChipmunkParameters::order),
       {}},
  };
}

std::vector<PlantedFault> teeFaults() {
  using pusht::kTeeX;
  using pusht::kTeeY;
  using pusht::kTeeYaw;
  const auto friction = [](double factor) {
    return [factor](Physics& physics) {
      physics.tee_friction = {factor * physics.tee_friction[0], factor * physics.tee_friction[1]};
      physics.tee_yaw_friction *= factor;
    };
  };
  const auto rigid_friction = [](double factor) {
    return [factor](RigidModel& model) {
      for (double& limit : model.coulomb_limit) {
        limit *= factor;
      }
    };
  };
  const std::vector<Property> of_friction = {P::kTeeFrictionX, P::kTeeFrictionY, P::kTeeYawFriction};
  return {
      {"tee mass times 1.3",
       {P::kTeeMass},
       mujocoWith(scaledMass("tee", 1.3, false)),
       chipmunkWith([](Physics& physics) {
         const double center = physics.centerOfMass();
         const double moment = physics.tee_second_moment - physics.tee_mass * center * center;
         physics.tee_mass *= 1.3;
         physics.tee_first_moment = physics.tee_mass * center;
         physics.tee_second_moment = moment + physics.tee_mass * center * center;
       }),
       rigidWith([](RigidModel& model) {
         model.tee_moment += 0.3 * model.tee_mass * pusht::kCenterOfMassOffset * pusht::kCenterOfMassOffset;
         model.tee_mass *= 1.3;
       })},
      {"moment times 1.3",
       {P::kTeeMoment},
       mujocoWith([](mjModel& m) { scaleMoment(m, 1.3); }),
       chipmunkWith([](Physics& p) { scaleMomentAboutCenter(p, 1.3); }),
       rigidWith([](RigidModel& m) { scaleRigidMoment(m, 1.3); })},
      {"moment without the stem's offset",
       {P::kTeeMoment},
       mujocoWith([](mjModel& m) { scaleMoment(m, momentWithoutOffset()); }),
       chipmunkWith([](Physics& p) { scaleMomentAboutCenter(p, momentWithoutOffset()); }),
       rigidWith([](RigidModel& m) { scaleRigidMoment(m, momentWithoutOffset()); })},
      {"center of mass off by 5 mm",
       {P::kCenterOfMass},
       mujocoWith([](mjModel& m) { shiftCenter(m, 0.005); }),
       chipmunkWith([](Physics& p) { shiftCenterOf(p, -0.005); }),
       {}},
      {"center of mass on the wrong side",
       {P::kCenterOfMass},
       mujocoWith([](mjModel& m) { shiftCenter(m, 2.0 * pusht::kCenterOfMassOffset); }),
       chipmunkWith([](Physics& p) { shiftCenterOf(p, -2.0 * p.centerOfMass()); }),
       {}},
      {"drag at the center of mass", {P::kDampingPoint, P::kFrictionPoint}, {}, chipmunkOf<DragAtTheCenter>(), {}},
      {"drag missing",
       {P::kTeeDamping, P::kTeeYawDamping},
       mujocoWith(scaledDamping({kTeeX, kTeeY, kTeeYaw}, 0.0)),
       chipmunkWith([](Physics& p) { p.tee_damping = p.tee_yaw_damping = 0.0; }),
       rigidWith([](RigidModel& m) { m.tee_damping = m.tee_yaw_damping = 0.0; })},
      {"damping times 1.3",
       {P::kTeeDamping},
       mujocoWith(scaledDamping({kTeeX, kTeeY}, 1.3)),
       chipmunkWith(scaled(&Physics::tee_damping, 1.3)),
       rigidWith(scaled(&RigidModel::tee_damping, 1.3))},
      {"yaw damping times 1.3",
       {P::kTeeYawDamping},
       mujocoWith(scaledDamping({kTeeYaw}, 1.3)),
       chipmunkWith(scaled(&Physics::tee_yaw_damping, 1.3)),
       rigidWith(scaled(&RigidModel::tee_yaw_damping, 1.3))},
      {"Coulomb friction of a disc", {P::kFrictionShape}, {}, chipmunkOf<FrictionOfADisc>(), {}},
      {"Coulomb friction doubled", of_friction, mujocoWith(scaledFriction({kTeeX, kTeeY, kTeeYaw}, 2.0)),
       chipmunkWith(friction(2.0)), rigidWith(rigid_friction(2.0))},
      {"Coulomb friction missing", of_friction, mujocoWith(scaledFriction({kTeeX, kTeeY, kTeeYaw}, 0.0)),
       chipmunkWith(friction(0.0)), rigidWith(rigid_friction(0.0))},
      {"yaw friction 100 times too small",
       {P::kTeeYawFriction},
       mujocoWith(scaledFriction({kTeeYaw}, 0.01)),
       chipmunkWith(scaled(&Physics::tee_yaw_friction, 0.01)),
       rigidWith([](RigidModel& m) { m.coulomb_limit[pusht::rigid_body::kTeeYaw] *= 0.01; })},
  };
}

std::vector<PlantedFault> contactFaults() {
  const auto friction = [](double coefficient) {
    return [coefficient](mjModel& model) {
      for (int geom = 0; geom < model.ngeom; ++geom) {
        model.geom_friction[3 * geom] = coefficient;
      }
    };
  };
  return {
      {"contact friction 0.5",
       {P::kContactFriction},
       mujocoWith(friction(0.5)),
       chipmunkWith(scaled(&Physics::contact_friction, 0.5)),
       {}},
      {"contact friction missing",
       {P::kContactFriction},
       mujocoWith(friction(1e-3)),
       chipmunkWith(scaled(&Physics::contact_friction, 0.0)),
       rigidWith([](RigidModel& m) { m.switches.friction = false; })},
      {"restitution 0.5", {P::kHit}, {}, chipmunkOf<Bouncing>(), {}},
      {"overlaps up to 0.1 m left alone", {P::kSlop}, {}, chipmunkWithout(&pusht::ChipmunkParameters::slop), {}},
      {"pusher radius + 1 mm",
       {P::kPusherRadius},
       mujocoWith([](mjModel& m) {
         m.geom_size[3 * geomOf(m, "pusher")] += 1e-3;
         m.geom_rbound[geomOf(m, "pusher")] += 1e-3;
       }),
       chipmunkWith([](Physics& p) { p.pusher_radius += 1e-3; }),
       {}},
      {"stem offset + 2 mm",
       {P::kStemEnd},
       mujocoWith([](mjModel& m) { moveGeom(m, "stem", 1, -2e-3); }),
       chipmunkWith([](Physics& p) { p.stem_offset += 2e-3; }),
       {}},
      {"bar 2 mm longer at both ends",
       {P::kBarHalfLength},
       mujocoWith([](mjModel& m) {
         m.geom_size[3 * geomOf(m, "bar")] += 2e-3;
         m.geom_rbound[geomOf(m, "bar")] += 2e-3;
       }),
       chipmunkWith([](Physics& p) { p.bar_half_length += 2e-3; }),
       {}},
      {"a wall off by 5 mm",
       {P::kWallRight},
       mujocoWith([](mjModel& m) { moveGeom(m, "wall_x_plus", 0, 5e-3); }),
       chipmunkOf<WallTooFar>(),
       {}},
      {"no walls", {P::kWallUp, P::kWallDown, P::kWallRight, P::kWallLeft}, {}, {}, rigidWith([](RigidModel& m) {
         m.switches.walls = false;
       })},
  };
}

}  // namespace

Measurements measured(const WorldFactory& make, std::uint64_t seed) {
  const auto world = make();
  Bench bench(*world, make, seed);
  return measure(bench);
}

WorldFactory cleanMujoco() {
  const auto scene = std::make_shared<const pusht::MujocoScene>();
  return [scene] { return std::make_unique<pusht::MujocoWorld>(scene); };
}

WorldFactory cleanChipmunk() {
  return [] { return pusht::worldOf<pusht::ChipmunkScene>(); };
}

WorldFactory cleanRigidBody() {
  return [] { return std::make_unique<pusht::RigidBodyEngine>(); };
}

std::vector<PlantedFault> plantedFaults() {
  std::vector<PlantedFault> all;
  for (const auto& group : {interfaceFaults(), timeFaults(), pusherFaults(), teeFaults(), contactFaults()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

}  // namespace sim2sim::testing
