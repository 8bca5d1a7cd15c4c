// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_chipmunk/chipmunk_world.hpp"

#include <chipmunk/chipmunk.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <vector>

#include "pusht_task/constants.hpp"

namespace pusht {
namespace chipmunk {

struct Free {
  void operator()(cpSpace* space) const { cpSpaceFree(space); }
  void operator()(cpBody* body) const { cpBodyFree(body); }
  void operator()(cpShape* shape) const { cpShapeFree(shape); }
  void operator()(cpConstraint* constraint) const { cpConstraintFree(constraint); }
};
template <class T>
using Owned = std::unique_ptr<T, Free>;

}  // namespace chipmunk

namespace {

// The tee with the mass that makes its damping implicit, which sits at the origin.
constexpr double kTeeMass = kBarMass + kStemMass + kSubstep * dynamics::kTeeDamping;  // [kg]
/// [m] from the tee's origin to the centre of this mass, along body -y.
constexpr double kTeeCenter = kStemOffset * kStemMass / kTeeMass;

/// [kg m^2] of a box with these half-sides about its middle.
constexpr double momentOfBox(double mass, double half_x, double half_y) {
  return mass * (half_x * half_x + half_y * half_y) / 3.0;
}
/// [kg m^2] about the centre of this mass.
constexpr double kTeeMoment =
    momentOfBox(kBarMass, kBarHalfLength, kTeeHalfWidth) + momentOfBox(kStemMass, kTeeHalfWidth, kStemHalfLength) +
    kStemMass * kStemOffset * kStemOffset + kSubstep * dynamics::kTeeYawDamping - kTeeMass * kTeeCenter * kTeeCenter;

constexpr double kPusherMass =
    dynamics::kPusherMass + kSubstep * (dynamics::kServoGain + dynamics::kPusherDamping);  // [kg]

constexpr double kFar = 2.0 * kPlausibleDistance;  // [m]

cpVect toChipmunk(const Eigen::Vector2d& vector) { return cpv(vector.x(), vector.y()); }
Eigen::Vector2d toEigen(const cpVect& vector) { return {vector.x, vector.y}; }

/// Chipmunk would move a body before it looks for collisions.
void stay(cpBody* /*body*/, cpFloat /*dt*/) {}

/// Debian's Chipmunk greets on stdout, where results belong, when a process makes its first space.
void greetInSilence() {
  static std::once_flag done;
  std::call_once(done, [] {
    std::fflush(stdout);
    const int out = dup(STDOUT_FILENO);
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    const bool silent = out >= 0 && nowhere >= 0 && dup2(nowhere, STDOUT_FILENO) >= 0;
    const chipmunk::Owned<cpSpace> first(cpSpaceNew());
    std::fflush(stdout);
    if (silent) {
      dup2(out, STDOUT_FILENO);
    }
    for (const int descriptor : {out, nowhere}) {
      if (descriptor >= 0) {
        close(descriptor);
      }
    }
  });
}

}  // namespace

std::string chipmunkVersion() { return cpVersionString; }

struct ChipmunkWorld::Scene {
  explicit Scene(const ChipmunkParameters& parameters) : space(cpSpaceNew()) {
    cpSpaceSetIterations(space.get(), parameters.iterations);
    cpSpaceSetCollisionSlop(space.get(), parameters.collision_slop);
    cpSpaceSetCollisionBias(space.get(), parameters.overlap_left);
    pusher = addBody(kPusherMass, INFINITY);
    tee = addBody(kTeeMass, kTeeMoment);
    cpBodySetCenterOfGravity(tee, cpv(0.0, -kTeeCenter));
    addWalls();
    addBox(tee, cpv(0.0, 0.0), kBarHalfLength, kTeeHalfWidth);
    addBox(tee, cpv(0.0, -kStemOffset), kTeeHalfWidth, kStemHalfLength);
    addShape(cpCircleShapeNew(pusher, kPusherRadius, cpvzero));
    addDryFriction();
  }

  cpBody* addBody(double mass, double moment) {
    bodies.emplace_back(cpSpaceAddBody(space.get(), cpBodyNew(mass, moment)));
    cpBodySetPositionUpdateFunc(bodies.back().get(), stay);
    return bodies.back().get();
  }

  void addShape(cpShape* shape) {
    shapes.emplace_back(cpSpaceAddShape(space.get(), shape));
    cpShapeSetFriction(shape, dynamics::kContactFriction);
  }

  void addBox(cpBody* body, cpVect middle, double half_x, double half_y) {
    addShape(cpBoxShapeNew2(body, cpBBNewForExtents(middle, half_x, half_y), 0.0));
  }

  void addWalls() {
    constexpr double kHalf = dynamics::kWallThickness / 2.0;
    constexpr double kMiddle = kWallInnerFace + kHalf;
    constexpr double kHalfLength = kWallInnerFace + dynamics::kWallThickness;
    cpBody* const table = cpSpaceGetStaticBody(space.get());
    addBox(table, cpv(0.0, kMiddle), kHalfLength, kHalf);
    addBox(table, cpv(0.0, -kMiddle), kHalfLength, kHalf);
    addBox(table, cpv(kMiddle, 0.0), kHalf, kHalfLength);
    addBox(table, cpv(-kMiddle, 0.0), kHalf, kHalfLength);
  }

  /// Of the table on the tee.
  void addDryFriction() {
    cpBody* const table = cpSpaceGetStaticBody(space.get());
    const auto add = [&](cpConstraint* constraint, double force) {
      constraints.emplace_back(cpSpaceAddConstraint(space.get(), constraint));
      cpConstraintSetMaxForce(constraint, force);
      cpConstraintSetMaxBias(constraint, 0.0);
    };
    add(cpGrooveJointNew(table, tee, cpv(0.0, -kFar), cpv(0.0, kFar), cpvzero), dynamics::kTeeFriction);
    add(cpGrooveJointNew(table, tee, cpv(-kFar, 0.0), cpv(kFar, 0.0), cpvzero), dynamics::kTeeFriction);
    add(cpSimpleMotorNew(table, tee, 0.0), dynamics::kTeeYawFriction);
  }

  /// [m] of the tee's centre of mass from its origin, in table axes.
  cpVect teeArm() const {
    return cpvsub(cpBodyLocalToWorld(tee, cpBodyGetCenterOfGravity(tee)), cpBodyGetPosition(tee));
  }

  cpVect teeVelocity() const {
    return cpvsub(cpBodyGetVelocity(tee), cpvmult(cpvperp(teeArm()), cpBodyGetAngularVelocity(tee)));
  }

  /// For the substep that comes: servo, damping.
  void applyForces(const cpVect& command) {
    const cpVect speed = cpBodyGetVelocity(pusher);
    const auto servo = [](double wanted, double found) {
      return std::clamp(dynamics::kServoGain * (wanted - found), -dynamics::kServoLimit, dynamics::kServoLimit) -
             dynamics::kPusherDamping * found;
    };
    cpBodySetForce(pusher, cpv(servo(command.x, speed.x), servo(command.y, speed.y)));
    const cpVect drag = cpvmult(teeVelocity(), -dynamics::kTeeDamping);
    cpBodySetForce(tee, drag);
    cpBodySetTorque(tee, -cpvcross(teeArm(), drag) - dynamics::kTeeYawDamping * cpBodyGetAngularVelocity(tee));
  }

  void substep(const cpVect& command) {
    applyForces(command);
    cpSpaceStep(space.get(), kSubstep);
    for (const chipmunk::Owned<cpBody>& body : bodies) {
      cpBodyUpdatePosition(body.get(), kSubstep);
    }
  }

  cpBody* pusher = nullptr;
  cpBody* tee = nullptr;
  std::vector<chipmunk::Owned<cpBody>> bodies;
  std::vector<chipmunk::Owned<cpShape>> shapes;
  std::vector<chipmunk::Owned<cpConstraint>> constraints;
  chipmunk::Owned<cpSpace> space;  // last, hence freed first: it looks at its bodies then
};

ChipmunkWorld::ChipmunkWorld(const ChipmunkParameters& parameters)
    : Simulator("Chipmunk", kStartTolerance), parameters_(parameters) {
  greetInSilence();
  scene_ = std::make_unique<Scene>(parameters_);
}

ChipmunkWorld::~ChipmunkWorld() = default;

void ChipmunkWorld::doReset(const WorldState& state) {
  scene_ = std::make_unique<Scene>(parameters_);
  cpBodySetPosition(scene_->pusher, toChipmunk(state.pusher_position));
  cpBodySetVelocity(scene_->pusher, toChipmunk(state.pusher_velocity));
  cpBody* const tee = scene_->tee;
  cpBodySetAngle(tee, state.tee_yaw);  // first: the origin is not the centre that it turns about
  cpBodySetPosition(tee, toChipmunk(state.tee_position));
  cpBodySetAngularVelocity(tee, state.tee_yaw_rate);
  cpBodySetVelocity(tee,
                    cpvadd(toChipmunk(state.tee_velocity), cpvmult(cpvperp(scene_->teeArm()), state.tee_yaw_rate)));
}

void ChipmunkWorld::doStep(const Action& action) {
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    scene_->substep(cpv(action[0], action[1]));
  }
}

WorldState ChipmunkWorld::doState() const {
  WorldState state;
  state.pusher_position = toEigen(cpBodyGetPosition(scene_->pusher));
  state.pusher_velocity = toEigen(cpBodyGetVelocity(scene_->pusher));
  state.tee_position = toEigen(cpBodyGetPosition(scene_->tee));
  state.tee_velocity = toEigen(scene_->teeVelocity());
  state.tee_yaw = wrapAngle(cpBodyGetAngle(scene_->tee));
  state.tee_yaw_rate = cpBodyGetAngularVelocity(scene_->tee);
  return state;
}

}  // namespace pusht
