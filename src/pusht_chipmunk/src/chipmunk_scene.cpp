// SPDX-License-Identifier: BSD-3-Clause
#include "chipmunk_scene.hpp"

#include <cmath>

#include "pusht_task/mapping.hpp"

namespace pusht::chipmunk {
namespace {

constexpr double kFar = 2.0 * kPlausibleDistance;  // [m]

cpVect toChipmunk(const Eigen::Vector2d& vector) { return cpv(vector.x(), vector.y()); }
Eigen::Vector2d toEigen(const cpVect& vector) { return {vector.x, vector.y}; }

/// Chipmunk would move a body before it looks for collisions.
void stay(cpBody* /*body*/, cpFloat /*dt*/) {}

/// Updates the velocity of a body that keeps the share of it which its user data point at.
void keepAShare(cpBody* body, cpVect gravity, cpFloat /*damping*/, cpFloat dt) {
  cpBodyUpdateVelocity(body, gravity, *static_cast<const double*>(cpBodyGetUserData(body)), dt);
}

}  // namespace

Scene::Scene(const ChipmunkParameters& parameters, const Physics& physics)
    : physics_(physics), parameters_(parameters), space_(cpSpaceNew()) {
  cpSpaceSetIterations(space_.get(), parameters.iterations);
  if (switches().slop) {
    cpSpaceSetCollisionSlop(space_.get(), parameters.collision_slop);
  }
  cpSpaceSetCollisionBias(space_.get(), parameters.overlap_left);
}

void Scene::start(const WorldState& state) {
  // Chipmunk solves in the order in which bodies and shapes were added, and last bits depend on it.
  pusher_ = addPusherBody();
  tee_ = addTeeBody();
  addWalls();
  for (const PlacedBox& box : teeBoxes(physics_)) {
    addBox(tee_, box);
  }
  addShape(cpCircleShapeNew(pusher_, physics_.pusher_radius, cpvzero));
  addDryFriction();

  cpBodySetPosition(pusher_, toChipmunk(state.pusher_position));
  cpBodySetVelocity(pusher_, toChipmunk(state.pusher_velocity));
  cpBodySetAngle(tee_, state.tee_yaw);  // first: the origin is not the center that it turns about
  cpBodySetPosition(tee_, toChipmunk(state.tee_position));
  cpBodySetAngularVelocity(tee_, state.tee_yaw_rate);
  cpBodySetVelocity(tee_, cpvadd(toChipmunk(state.tee_velocity), cpvmult(cpvperp(teeArm()), state.tee_yaw_rate)));
}

cpBody* Scene::addPusherBody() {
  cpBody* const pusher = addBody(pusherMass(physics_, switches().servo ? parameters_.substep : 0.0), INFINITY);
  if (switches().servo) {
    return pusher;
  }
  bodies_.emplace_back(cpSpaceAddBody(space_.get(), cpBodyNewKinematic()));
  command_ = bodies_.back().get();
  addFriction(cpPivotJointNew2(command_, pusher, cpvzero, cpvzero), physics_.servo_limit);
  return pusher;
}

cpBody* Scene::addTeeBody() {
  const TeeInertia inertia = teeInertia(physics_, switches().drag ? parameters_.substep : 0.0);
  cpBody* const tee = addBody(inertia.mass, inertia.momentAboutCenter());
  cpBodySetCenterOfGravity(tee, cpv(0.0, -inertia.center()));
  if (!switches().drag) {
    tee_keeps_ = std::exp(-parameters_.substep * physics_.tee_damping / physics_.tee_mass);
    cpBodySetUserData(tee, &tee_keeps_);
    cpBodySetVelocityUpdateFunc(tee, keepAShare);
  }
  return tee;
}

cpBody* Scene::addBody(double mass, double moment) {
  bodies_.emplace_back(cpSpaceAddBody(space_.get(), cpBodyNew(mass, moment)));
  if (switches().order) {
    cpBodySetPositionUpdateFunc(bodies_.back().get(), stay);
  }
  return bodies_.back().get();
}

void Scene::addShape(cpShape* shape) {
  shapes_.emplace_back(cpSpaceAddShape(space_.get(), shape));
  cpShapeSetFriction(shape, physics_.contact_friction);
}

void Scene::addBox(cpBody* body, const PlacedBox& box) {
  addShape(cpBoxShapeNew2(body, cpBBNewForExtents(cpv(box.x, box.y), box.half_x, box.half_y), 0.0));
}

void Scene::addWalls() {
  for (const PlacedBox& wall : wallBoxes(physics_)) {
    addBox(table(), wall);
  }
}

void Scene::addFriction(cpConstraint* constraint, double force) {
  constraints_.emplace_back(cpSpaceAddConstraint(space_.get(), constraint));
  cpConstraintSetMaxForce(constraint, force);
  cpConstraintSetMaxBias(constraint, 0.0);
}

void Scene::addDryFriction() {
  if (!switches().table_friction) {
    addFriction(cpPivotJointNew2(table(), tee_, cpvzero, cpvzero), physics_.tee_friction[0]);
    addFriction(cpGearJointNew(table(), tee_, 0.0, 1.0), physics_.tee_yaw_friction);
    return;
  }
  addFriction(cpGrooveJointNew(table(), tee_, cpv(0.0, -kFar), cpv(0.0, kFar), cpvzero), physics_.tee_friction[0]);
  addFriction(cpGrooveJointNew(table(), tee_, cpv(-kFar, 0.0), cpv(kFar, 0.0), cpvzero), physics_.tee_friction[1]);
  addFriction(cpSimpleMotorNew(table(), tee_, 0.0), physics_.tee_yaw_friction);
}

cpVect Scene::teeArm() const {
  return cpvsub(cpBodyLocalToWorld(tee_, cpBodyGetCenterOfGravity(tee_)), cpBodyGetPosition(tee_));
}

cpVect Scene::teeVelocity() const {
  return cpvsub(cpBodyGetVelocity(tee_), cpvmult(cpvperp(teeArm()), cpBodyGetAngularVelocity(tee_)));
}

void Scene::applyServo(const cpVect& command) {
  if (command_ != nullptr) {
    cpBodySetVelocity(command_, command);
    return;
  }
  const cpVect speed = cpBodyGetVelocity(pusher_);
  cpBodySetForce(pusher_, cpv(pusherForce(physics_, command.x, speed.x), pusherForce(physics_, command.y, speed.y)));
}

void Scene::applyForces(const cpVect& command) {
  applyServo(command);
  if (!switches().drag) {
    return;
  }
  const cpVect drag = cpvmult(teeVelocity(), -physics_.tee_damping);
  cpBodySetForce(tee_, drag);
  cpBodySetTorque(tee_, -cpvcross(teeArm(), drag) - physics_.tee_yaw_damping * cpBodyGetAngularVelocity(tee_));
}

void Scene::substep(const cpVect& command) {
  applyForces(command);
  cpSpaceStep(space_.get(), parameters_.substep);
  if (switches().order) {
    cpBodyUpdatePosition(pusher_, parameters_.substep);
    cpBodyUpdatePosition(tee_, parameters_.substep);
  }
}

WorldState Scene::state() const {
  WorldState state;
  state.pusher_position = toEigen(cpBodyGetPosition(pusher_));
  state.pusher_velocity = toEigen(cpBodyGetVelocity(pusher_));
  state.tee_position = toEigen(cpBodyGetPosition(tee_));
  state.tee_velocity = toEigen(teeVelocity());
  state.tee_yaw = wrapAngle(cpBodyGetAngle(tee_));
  state.tee_yaw_rate = cpBodyGetAngularVelocity(tee_);
  return state;
}

}  // namespace pusht::chipmunk
