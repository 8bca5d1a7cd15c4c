// SPDX-License-Identifier: BSD-3-Clause
#include "chipmunk_scene.hpp"

#include <algorithm>
#include <cmath>

#include "pusht_task/constants.hpp"

namespace pusht::chipmunk {
namespace {

constexpr double kFar = 2.0 * kPlausibleDistance;  // [m]

cpVect toChipmunk(const Eigen::Vector2d& vector) { return cpv(vector.x(), vector.y()); }
Eigen::Vector2d toEigen(const cpVect& vector) { return {vector.x, vector.y}; }

/// Chipmunk would move a body before it looks for collisions.
void stay(cpBody* /*body*/, cpFloat /*dt*/) {}

}  // namespace

Scene::Scene(const ChipmunkParameters& parameters, const Physics& physics)
    : physics_(physics), substep_(parameters.substep), space_(cpSpaceNew()) {
  cpSpaceSetIterations(space_.get(), parameters.iterations);
  cpSpaceSetCollisionSlop(space_.get(), parameters.collision_slop);
  cpSpaceSetCollisionBias(space_.get(), parameters.overlap_left);
}

void Scene::start(const WorldState& state) {
  // Chipmunk solves in the order in which bodies and shapes were added, and last bits depend on it.
  pusher_ = addBody(physics_.pusher_mass + substep_ * (physics_.servo_gain + physics_.pusher_damping), INFINITY);
  tee_ = addTeeBody();
  addWalls();
  addBox(tee_, cpv(0.0, 0.0), physics_.bar_half_length, physics_.bar_half_width);
  addBox(tee_, cpv(0.0, -physics_.stem_offset), physics_.stem_half_width, physics_.stem_half_length);
  addShape(cpCircleShapeNew(pusher_, physics_.pusher_radius, cpvzero));
  addDryFriction();

  cpBodySetPosition(pusher_, toChipmunk(state.pusher_position));
  cpBodySetVelocity(pusher_, toChipmunk(state.pusher_velocity));
  cpBodySetAngle(tee_, state.tee_yaw);  // first: the origin is not the center that it turns about
  cpBodySetPosition(tee_, toChipmunk(state.tee_position));
  cpBodySetAngularVelocity(tee_, state.tee_yaw_rate);
  cpBodySetVelocity(tee_, cpvadd(toChipmunk(state.tee_velocity), cpvmult(cpvperp(teeArm()), state.tee_yaw_rate)));
}

cpBody* Scene::addTeeBody() {
  // With the mass that makes its damping implicit, which sits at the origin.
  const double mass = physics_.tee_mass + substep_ * physics_.tee_damping;  // [kg]
  const double center = physics_.tee_first_moment / mass;                   // [m] along body -y
  const double moment =                                                     // [kg m^2] about that center
      physics_.tee_second_moment + substep_ * physics_.tee_yaw_damping - mass * center * center;
  cpBody* const tee = addBody(mass, moment);
  cpBodySetCenterOfGravity(tee, cpv(0.0, -center));
  return tee;
}

cpBody* Scene::addBody(double mass, double moment) {
  bodies_.emplace_back(cpSpaceAddBody(space_.get(), cpBodyNew(mass, moment)));
  cpBodySetPositionUpdateFunc(bodies_.back().get(), stay);
  return bodies_.back().get();
}

void Scene::addShape(cpShape* shape) {
  shapes_.emplace_back(cpSpaceAddShape(space_.get(), shape));
  cpShapeSetFriction(shape, physics_.contact_friction);
}

void Scene::addBox(cpBody* body, cpVect center, double half_x, double half_y) {
  addShape(cpBoxShapeNew2(body, cpBBNewForExtents(center, half_x, half_y), 0.0));
}

void Scene::addWalls() {
  constexpr double kHalf = dynamics::kWallThickness / 2.0;
  const double middle = physics_.wall_inner_face + kHalf;
  const double half_length = physics_.wall_inner_face + dynamics::kWallThickness;
  addBox(table(), cpv(0.0, middle), half_length, kHalf);
  addBox(table(), cpv(0.0, -middle), half_length, kHalf);
  addBox(table(), cpv(middle, 0.0), kHalf, half_length);
  addBox(table(), cpv(-middle, 0.0), kHalf, half_length);
}

void Scene::addFriction(cpConstraint* constraint, double force) {
  constraints_.emplace_back(cpSpaceAddConstraint(space_.get(), constraint));
  cpConstraintSetMaxForce(constraint, force);
  cpConstraintSetMaxBias(constraint, 0.0);
}

void Scene::addDryFriction() {
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
  const cpVect speed = cpBodyGetVelocity(pusher_);
  const auto servo = [this](double wanted, double found) {
    return std::clamp(physics_.servo_gain * (wanted - found), -physics_.servo_limit, physics_.servo_limit) -
           physics_.pusher_damping * found;
  };
  cpBodySetForce(pusher_, cpv(servo(command.x, speed.x), servo(command.y, speed.y)));
}

void Scene::applyForces(const cpVect& command) {
  applyServo(command);
  const cpVect drag = cpvmult(teeVelocity(), -physics_.tee_damping);
  cpBodySetForce(tee_, drag);
  cpBodySetTorque(tee_, -cpvcross(teeArm(), drag) - physics_.tee_yaw_damping * cpBodyGetAngularVelocity(tee_));
}

void Scene::substep(const cpVect& command) {
  applyForces(command);
  cpSpaceStep(space_.get(), substep_);
  for (const Owned<cpBody>& body : bodies_) {
    cpBodyUpdatePosition(body.get(), substep_);
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
