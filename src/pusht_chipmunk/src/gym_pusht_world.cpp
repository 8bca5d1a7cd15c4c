// SPDX-License-Identifier: BSD-3-Clause
#include "gym_pusht_world.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "chipmunk_types.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/physics.hpp"
#include "pusht_task/task.hpp"

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

const Physics& sound() { return gymPusht().physics; }

/// [px] From the tee's origin to the center of mass of a uniform tee.
double soundCenter() { return gym_pusht::kBarCenter + gym_pusht::kPixelsPerMeter * sound().centerOfMass(); }

/// [kg px^2] Moment of inertia of a uniform tee about its center of mass.
double soundMoment() {
  const double square_meters = sound().tee_second_moment - sound().tee_first_moment * sound().centerOfMass();
  return square_meters * gym_pusht::kPixelsPerMeter * gym_pusht::kPixelsPerMeter;
}

/// [px] From the tee's origin.
double centerOfGravityIn(const GymPushtQuirks& quirks) {
  return quirks.center ? gym_pusht::kCenterOfGravity : soundCenter();
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
  Space(const GymPushtQuirks& quirks, const gym_pusht::Variant& variant) : quirks_(quirks), space_(cpSpaceNew()) {
    const double usual = quirks.coasting ? 0.0 : std::exp(-sound().tee_damping / sound().tee_mass);
    cpSpaceSetDamping(space_.get(), variant.damping.value_or(usual));
    for (const auto& [begin, end] : kWalls) {
      add(cpSegmentShapeNew(cpSpaceGetStaticBody(space_.get()), begin, end, kWallRadius));
    }
    addPusher();
    addTee();
    if (variant.block_cog) {
      cpBodySetCenterOfGravity(tee_, toChipmunk(*variant.block_cog));
    }
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

  /// Returns the number of the tee's contact points.
  int substep() {
    cpSpaceStep(space_.get(), kStep);
    int contacts = 0;
    cpBodyEachArbiter(tee_, countContacts, &contacts);
    return contacts;
  }

  /// Accelerates the pusher towards `target`, in gym-pusht's order of operations.
  void drive(const cpVect& target) {
    const cpVect position = cpBodyGetPosition(pusher_);
    const cpVect velocity = cpBodyGetVelocity(pusher_);
    cpBodySetVelocity(pusher_, cpv(velocity.x + accelerationOf(target.x - position.x, velocity.x) * kStep,
                                   velocity.y + accelerationOf(target.y - position.y, velocity.y) * kStep));
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
  static void countContacts(cpBody* /*tee*/, cpArbiter* arbiter, void* count) {
    *static_cast<int*>(count) += cpArbiterGetCount(arbiter);
  }

  /// [px/s^2] Along an axis.
  double accelerationOf(double way, double velocity) const {
    const double acceleration = gym_pusht::kStiffness * way + gym_pusht::kDamping * (0.0 - velocity);
    const double limit = gym_pusht::kPixelsPerMeter * sound().servo_limit / sound().pusher_mass;
    return quirks_.kinematic ? acceleration : std::clamp(acceleration, -limit, limit);
  }

  void addPusher() {
    bodies_.emplace_back(quirks_.kinematic ? cpBodyNewKinematic() : cpBodyNew(sound().pusher_mass, INFINITY));
    pusher_ = bodies_.back().get();
    cpBodySetPosition(pusher_, kFirstPusher);
    if (!quirks_.kinematic) {
      cpBodySetVelocityUpdateFunc(pusher_, keepVelocity);
    }
    cpSpaceAddBody(space_.get(), pusher_);
    add(cpCircleShapeNew(pusher_, kRadius, cpvzero));
  }

  void addTee() {
    bodies_.emplace_back(cpBodyNew(kTeeMass, quirks_.inertia ? quirkyMoment() : soundMoment()));
    tee_ = bodies_.back().get();
    cpBodySetCenterOfGravity(tee_, cpv(0.0, centerOfGravityIn(quirks_)));
    cpBodySetPosition(tee_, kFirstTee);
    cpBodySetAngle(tee_, 0.0);
    cpSpaceAddBody(space_.get(), tee_);
    for (const auto& part : {kBar, kStem}) {
      add(cpPolyShapeNew(tee_, static_cast<int>(part.size()), part.data(), cpTransformIdentity, 0.0));
    }
  }

  void add(cpShape* shape) {
    shapes_.emplace_back(cpSpaceAddShape(space_.get(), shape));
    cpShapeSetFriction(shape, quirks_.contact_friction ? 0.0 : sound().contact_friction);
  }

  GymPushtQuirks quirks_;
  cpBody* pusher_ = nullptr;
  cpBody* tee_ = nullptr;
  std::vector<Owned<cpBody>> bodies_;
  std::vector<Owned<cpShape>> shapes_;
  Owned<cpSpace> space_;  // last, hence freed first: it looks at its bodies then
};

GymPushtWorld::GymPushtWorld(const GymPushtQuirks& quirks, const GymPushtResets& resets,
                             const gym_pusht::Variant& variant)
    : quirks_(quirks), resets_(resets), variant_(variant), space_(std::make_unique<Space>(quirks, variant)) {}

GymPushtWorld::~GymPushtWorld() = default;

void GymPushtWorld::reset(const State& asked) {
  space_ = std::make_unique<Space>(quirks_, variant_);
  space_->place(asked, resets_.legacy_order);
  contacts_ = resets_.first_substep ? space_->substep() : 0;
}

void GymPushtWorld::restore(const State& state) {
  space_ = std::make_unique<Space>(quirks_, variant_);
  space_->place(state, false);
  space_->setVelocities(state);
  const bool at_rest = state.pusher_velocity.isZero(0.0) && state.tee_velocity.isZero(0.0) && state.rate == 0.0;
  contacts_ = at_rest && resets_.first_substep ? space_->substep() : 0;
}

void GymPushtWorld::step(const Eigen::Vector2d& target) {
  contacts_ = 0;
  for (int i = 0; i < kSubstepsPerControlStep; ++i) {
    space_->drive(toChipmunk(target));
    contacts_ += space_->substep();
  }
}

State GymPushtWorld::state() const { return space_->state(); }

int GymPushtWorld::contacts() const { return contacts_; }

double GymPushtWorld::centerOfGravity() const { return centerOfGravityIn(quirks_); }

}  // namespace pusht
