// SPDX-License-Identifier: BSD-3-Clause
#include "chipmunk_scene.hpp"

#include <cmath>

namespace pusht {
namespace {

constexpr double kFar = 2.0 * kPlausibleDistance;  // [m]

/// Chipmunk would move a body before it looks for collisions.
void stay(cpBody* /*body*/, cpFloat /*dt*/) {}

/// Updates the velocity of a body that keeps the share of it which its user data point at.
void keepAShare(cpBody* body, cpVect gravity, cpFloat /*damping*/, cpFloat dt) {
  cpBodyUpdateVelocity(body, gravity, *static_cast<const double*>(cpBodyGetUserData(body)), dt);
}

}  // namespace

ChipmunkScene::ChipmunkScene(const ChipmunkParameters& parameters, const Physics& physics)
    : Scene(parameters, physics), parameters_(parameters), space_(cpSpaceNew()) {
  cpSpaceSetIterations(space_.get(), static_cast<int>(parameters.iterations));
  if (parameters.slop) {
    cpSpaceSetCollisionSlop(space_.get(), parameters.collision_slop);
  }
  cpSpaceSetCollisionBias(space_.get(), parameters.overlap_left);
}

WorldState ChipmunkScene::start(const WorldState& state) {
  // Chipmunk solves in the order in which bodies and shapes were added, and last bits depend on it.
  pusher_ = addPusherBody();
  tee_ = addTeeBody();
  addWalls();
  for (const PlacedBox& box : teeBoxes(physics())) {
    addBox(tee_, box);
  }
  addShape(cpCircleShapeNew(pusher_, physics().pusher_radius, cpvzero));
  addTableFriction();

  cpBodySetPosition(pusher_, toChipmunk(state.pusher_position));
  cpBodySetVelocity(pusher_, toChipmunk(state.pusher_velocity));
  cpBodySetAngle(tee_, state.tee_yaw);  // first: the origin is not the center that it turns about
  cpBodySetPosition(tee_, toChipmunk(state.tee_position));
  cpBodySetAngularVelocity(tee_, state.tee_yaw_rate);
  cpBodySetVelocity(tee_,
                    cpvadd(toChipmunk(state.tee_velocity), cpvmult(cpvperp(teeArm(cpvzero)), state.tee_yaw_rate)));
  return this->state();
}

cpBody* ChipmunkScene::addPusherBody() {
  cpBody* const pusher = addBody(pusherMass(), INFINITY);
  if (parameters_.servo) {
    return pusher;
  }
  bodies_.emplace_back(cpSpaceAddBody(space_.get(), cpBodyNewKinematic()));
  command_ = bodies_.back().get();
  addFriction(cpPivotJointNew2(command_, pusher, cpvzero, cpvzero), physics().servo_limit);
  return pusher;
}

cpBody* ChipmunkScene::addTeeBody() {
  const TeeInertia inertia = teeInertia();
  cpBody* const tee = addBody(inertia.mass, inertia.momentAboutCenter());
  cpBodySetCenterOfGravity(tee, cpv(0.0, -inertia.center()));
  if (!parameters_.drag) {
    tee_keeps_ = std::exp(-parameters_.substep * physics().tee_damping / physics().tee_mass);
    cpBodySetUserData(tee, &tee_keeps_);
    cpBodySetVelocityUpdateFunc(tee, keepAShare);
  }
  return tee;
}

cpBody* ChipmunkScene::addBody(double mass, double moment) {
  bodies_.emplace_back(cpSpaceAddBody(space_.get(), cpBodyNew(mass, moment)));
  if (parameters_.order) {
    cpBodySetPositionUpdateFunc(bodies_.back().get(), stay);
  }
  return bodies_.back().get();
}

void ChipmunkScene::addShape(cpShape* shape) {
  shapes_.emplace_back(cpSpaceAddShape(space_.get(), shape));
  cpShapeSetFriction(shape, std::sqrt(physics().contact_friction));  // those of two bodies are multiplied
}

void ChipmunkScene::addBox(cpBody* body, const PlacedBox& box) {
  addShape(cpBoxShapeNew2(body, cpBBNewForExtents(cpv(box.x, box.y), box.half_x, box.half_y), 0.0));
}

void ChipmunkScene::addFriction(cpConstraint* constraint, double force) {
  constraints_.emplace_back(cpSpaceAddConstraint(space_.get(), constraint));
  cpConstraintSetMaxForce(constraint, force);
  cpConstraintSetMaxBias(constraint, 0.0);
}

void ChipmunkScene::addFrictionPerAxis(const Eigen::Vector2d& point) {
  const cpVect local = toChipmunk(point);
  addFriction(cpGrooveJointNew(table(), tee_, cpv(0.0, -kFar), cpv(0.0, kFar), local), physics().tee_friction[0]);
  addFriction(cpGrooveJointNew(table(), tee_, cpv(-kFar, 0.0), cpv(kFar, 0.0), local), physics().tee_friction[1]);
  addFriction(cpSimpleMotorNew(table(), tee_, 0.0), physics().tee_yaw_friction);
}

void ChipmunkScene::addIdiomaticFriction() {
  addFriction(cpPivotJointNew2(table(), tee_, cpvzero, cpvzero), physics().tee_friction[0]);
  addFriction(cpGearJointNew(table(), tee_, 0.0, 1.0), physics().tee_yaw_friction);
}

cpVect ChipmunkScene::teeArm(const cpVect& point) const {
  return cpvsub(cpBodyLocalToWorld(tee_, cpBodyGetCenterOfGravity(tee_)), cpBodyLocalToWorld(tee_, point));
}

cpVect ChipmunkScene::teeVelocity(const cpVect& point) const {
  return cpvsub(cpBodyGetVelocity(tee_), cpvmult(cpvperp(teeArm(point)), cpBodyGetAngularVelocity(tee_)));
}

void ChipmunkScene::applyServo(const Eigen::Vector2d& command) {
  if (command_ != nullptr) {
    cpBodySetVelocity(command_, toChipmunk(command));
    return;
  }
  const cpVect place = cpBodyGetPosition(pusher_);
  const cpVect speed = cpBodyGetVelocity(pusher_);
  cpBodySetForce(pusher_, cpv(pusherForce(physics(), command.x(), place.x, speed.x),
                              pusherForce(physics(), command.y(), place.y, speed.y)));
}

void ChipmunkScene::applyDragAt(const Eigen::Vector2d& point) {
  const cpVect local = toChipmunk(point);
  const cpVect drag = cpvmult(teeVelocity(local), -physics().tee_damping);
  cpBodySetForce(tee_, drag);
  cpBodySetTorque(tee_, -cpvcross(teeArm(local), drag) - physics().tee_yaw_damping * cpBodyGetAngularVelocity(tee_));
}

void ChipmunkScene::advance() {
  cpSpaceStep(space_.get(), parameters_.substep);
  if (parameters_.order) {
    cpBodyUpdatePosition(pusher_, parameters_.substep);
    cpBodyUpdatePosition(tee_, parameters_.substep);
  }
}

WorldState ChipmunkScene::state() const {
  WorldState state;
  state.pusher_position = toEigen(cpBodyGetPosition(pusher_));
  state.pusher_velocity = toEigen(cpBodyGetVelocity(pusher_));
  state.tee_position = toEigen(cpBodyGetPosition(tee_));
  state.tee_velocity = toEigen(teeVelocity(cpvzero));
  state.tee_yaw = wrapAngle(cpBodyGetAngle(tee_));
  state.tee_yaw_rate = cpBodyGetAngularVelocity(tee_);
  return state;
}

}  // namespace pusht
