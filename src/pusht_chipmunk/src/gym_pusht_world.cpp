// SPDX-License-Identifier: BSD-3-Clause
#include "gym_pusht_world.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "chipmunk_types.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/mapping.hpp"
#include "pusht_task/physics.hpp"

namespace pusht {
namespace {

using gym_pusht::State;

constexpr double kStep = kSubstep;  // [s]

// Sizes [px], as gym-pusht writes them.
constexpr double kRadius = 15.0;
constexpr double kWallRadius = 2.0;
constexpr std::array kWalls = {std::pair(cpVect{5, 506}, cpVect{5, 5}), std::pair(cpVect{5, 5}, cpVect{506, 5}),
                               std::pair(cpVect{506, 5}, cpVect{506, 506}),
                               std::pair(cpVect{5, 506}, cpVect{506, 506})};
constexpr std::array kBar = {cpVect{-60, 30}, cpVect{60, 30}, cpVect{60, 0}, cpVect{-60, 0}};
constexpr std::array kStem = {cpVect{-15, 30}, cpVect{-15, 120}, cpVect{15, 120}, cpVect{15, 30}};
constexpr cpVect kFirstPusher = {256, 400};
constexpr cpVect kFirstTee = {256, 300};
constexpr double kTeeMass = 1.0;  // [kg]

// Drive: a proportional-derivative controller of the pusher's acceleration.
constexpr double kStiffness = 100.0;  // [1/s^2]
constexpr double kDamping = 20.0;     // [1/s]

// A sound world: what gym-pusht leaves open has the course's proportions.
constexpr double kSoundPusherMass = 2.0;                                          // [kg]
constexpr double kSoundLimit = 300.0 * gym_pusht::kPixelsPerMeter;                // [kg px/s^2]
constexpr double kSoundDamping = dynamics::kTeeDamping / (kBarMass + kStemMass);  // [1/s]
constexpr double kSoundFriction = 1.0;                                            // [-]

/// [px] From the tee's origin to the center of mass of a uniform tee.
double soundCenter() {
  const double bar = cpAreaForPoly(static_cast<int>(kBar.size()), kBar.data(), 0.0);
  const double stem = cpAreaForPoly(static_cast<int>(kStem.size()), kStem.data(), 0.0);
  const double bar_center = cpCentroidForPoly(static_cast<int>(kBar.size()), kBar.data()).y;
  const double stem_center = cpCentroidForPoly(static_cast<int>(kStem.size()), kStem.data()).y;
  return (bar * bar_center + stem * stem_center) / (bar + stem);
}

/// [kg px^2] Moment of inertia of a uniform tee about its center of mass.
double soundMoment() {
  const double bar = cpAreaForPoly(static_cast<int>(kBar.size()), kBar.data(), 0.0);
  const double stem = cpAreaForPoly(static_cast<int>(kStem.size()), kStem.data(), 0.0);
  const cpVect to_center = cpv(0.0, -soundCenter());
  const auto moment = [&](double share, const auto& part) {
    return cpMomentForPoly(kTeeMass * share, static_cast<int>(part.size()), part.data(), to_center, 0.0);
  };
  return moment(bar / (bar + stem), kBar) + moment(stem / (bar + stem), kStem);
}

/// gym-pusht takes the bar's moment for the stem's, too, and about the origin.
double quirkyMoment() {
  return 2.0 * cpMomentForPoly(kTeeMass, static_cast<int>(kBar.size()), kBar.data(), cpvzero, 0.0);
}

/// Updates a velocity that the space's damping must not touch.
void keepVelocity(cpBody* body, cpVect gravity, cpFloat /*damping*/, cpFloat dt) {
  cpBodyUpdateVelocity(body, gravity, 1.0, dt);
}

}  // namespace

/// Space of Chipmunk with what gym-pusht puts into it.
class GymPushtWorld::Space {
 public:
  explicit Space(const GymPushtQuirks& quirks) : quirks_(quirks), space_(cpSpaceNew()) {
    cpSpaceSetDamping(space_.get(), quirks.coasting ? 0.0 : std::exp(-kSoundDamping));
    for (const auto& [begin, end] : kWalls) {
      add(cpSegmentShapeNew(cpSpaceGetStaticBody(space_.get()), begin, end, kWallRadius));
    }
    addPusher();
    addTee();
  }

  /// The tee turns about its center of gravity, so that the order counts.
  void place(const State& state, bool position_first) {
    cpBodySetPosition(pusher_, toChipmunk(state.pusher));
    if (position_first) {
      cpBodySetPosition(tee_, toChipmunk(state.tee));
    }
    cpBodySetAngle(tee_, state.angle);
    if (!position_first) {
      cpBodySetPosition(tee_, toChipmunk(state.tee));
    }
  }

  void setVelocities(const State& state) {
    cpBodySetVelocity(pusher_, toChipmunk(state.pusher_velocity));
    cpBodySetVelocity(tee_, toChipmunk(state.tee_velocity));
    cpBodySetAngularVelocity(tee_, state.rate);
  }

  void substep() { cpSpaceStep(space_.get(), kStep); }

  /// Accelerates the pusher towards `target`, in gym-pusht's order of operations.
  void drive(const cpVect& target) {
    const cpVect position = cpBodyGetPosition(pusher_);
    const cpVect velocity = cpBodyGetVelocity(pusher_);
    cpVect acceleration = cpv(kStiffness * (target.x - position.x) + kDamping * (0.0 - velocity.x),
                              kStiffness * (target.y - position.y) + kDamping * (0.0 - velocity.y));
    if (!quirks_.kinematic) {
      acceleration = cpvclamp(acceleration, kSoundLimit / kSoundPusherMass);
    }
    cpBodySetVelocity(pusher_, cpv(velocity.x + acceleration.x * kStep, velocity.y + acceleration.y * kStep));
  }

  State state() const {
    State state;
    state.pusher = toEigen(cpBodyGetPosition(pusher_));
    state.pusher_velocity = toEigen(cpBodyGetVelocity(pusher_));
    state.tee = toEigen(cpBodyGetPosition(tee_));
    state.angle = cpBodyGetAngle(tee_);
    state.tee_velocity = toEigen(cpBodyGetVelocity(tee_));
    state.rate = cpBodyGetAngularVelocity(tee_);
    return state;
  }

 private:
  cpShape* add(cpShape* shape) {
    shapes_.emplace_back(cpSpaceAddShape(space_.get(), shape));
    return shape;
  }

  void addPusher() {
    bodies_.emplace_back(quirks_.kinematic ? cpBodyNewKinematic() : cpBodyNew(kSoundPusherMass, INFINITY));
    pusher_ = bodies_.back().get();
    cpBodySetPosition(pusher_, kFirstPusher);
    if (!quirks_.kinematic) {
      cpBodySetVelocityUpdateFunc(pusher_, keepVelocity);
    }
    cpSpaceAddBody(space_.get(), pusher_);
    addWithFriction(cpCircleShapeNew(pusher_, kRadius, cpvzero));
  }

  void addTee() {
    bodies_.emplace_back(cpBodyNew(kTeeMass, quirks_.inertia ? quirkyMoment() : soundMoment()));
    tee_ = bodies_.back().get();
    cpBodySetCenterOfGravity(tee_, cpv(0.0, centerOfGravityIn(quirks_)));
    cpBodySetPosition(tee_, kFirstTee);
    cpBodySetAngle(tee_, 0.0);
    cpSpaceAddBody(space_.get(), tee_);
    for (const auto& part : {kBar, kStem}) {
      addWithFriction(cpPolyShapeNew(tee_, static_cast<int>(part.size()), part.data(), cpTransformIdentity, 0.0));
    }
  }

  void addWithFriction(cpShape* shape) {
    add(shape);
    cpShapeSetFriction(shape, quirks_.contact_friction ? 0.0 : kSoundFriction);
  }

  static double centerOfGravityIn(const GymPushtQuirks& quirks) {
    return quirks.center ? gym_pusht::kCenterOfGravity : soundCenter();
  }

  GymPushtQuirks quirks_;
  cpBody* pusher_ = nullptr;
  cpBody* tee_ = nullptr;
  std::vector<Owned<cpBody>> bodies_;
  std::vector<Owned<cpShape>> shapes_;
  Owned<cpSpace> space_;  // last, hence freed first: it looks at its bodies then
};

GymPushtWorld::GymPushtWorld(const GymPushtQuirks& quirks) : quirks_(quirks), space_(std::make_unique<Space>(quirks)) {}

GymPushtWorld::~GymPushtWorld() = default;

void GymPushtWorld::reset(const State& asked) {
  space_ = std::make_unique<Space>(quirks_);
  space_->place(asked, quirks_.legacy_order);
  if (quirks_.first_substep) {
    space_->substep();
  }
}

void GymPushtWorld::restore(const State& state) {
  space_ = std::make_unique<Space>(quirks_);
  space_->place(state, false);
  space_->setVelocities(state);
}

void GymPushtWorld::step(const Eigen::Vector2d& target) {
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    space_->drive(toChipmunk(target));
    space_->substep();
  }
}

State GymPushtWorld::state() const { return space_->state(); }

double GymPushtWorld::centerOfGravity() const { return quirks_.center ? gym_pusht::kCenterOfGravity : soundCenter(); }

}  // namespace pusht
