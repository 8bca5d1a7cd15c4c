// SPDX-License-Identifier: BSD-3-Clause
#include "bullet_scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht {
namespace {

constexpr double kTeeMargin = 1e-4;  // [m]
constexpr double kTouch = 1e-6;      // [m] distance from which on bodies touch; at 0 a contact that holds would flicker
constexpr double kTeeHalfHeight = 0.015;    // [m]
constexpr double kPusherHalfHeight = 0.02;  // [m]
constexpr double kWallHalfHeight = 0.025;   // [m] so that no top is level with another
constexpr double kGravity = 9.81;           // [m/s^2]
constexpr int kTableGroup = 1 << 10;        // what the pusher does not touch
const btVector3 kInThePlane = {1.0, 1.0, 0.0};

btVector3 toBullet(const Eigen::Vector2d& vector) { return {vector.x(), vector.y(), 0.0}; }
Eigen::Vector2d toEigen(const btVector3& vector) { return {vector.x(), vector.y()}; }

btTransform at(const btVector3& place, double yaw = 0.0) {
  const double c = std::cos(yaw);
  const double s = std::sin(yaw);
  return btTransform(btMatrix3x3(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0), place);
}

/// The setting d of Bullet's damping, which leaves (1 - d) of a velocity after a second, for a rate [1/s] of decay: in
/// double precision at most 36.7, for the next number is 1, which stops a body at once.
double dampingOf(double rate) { return std::min(-std::expm1(-rate), std::nextafter(1.0, 0.0)); }

}  // namespace

btDefaultCollisionConstructionInfo BulletScene::smallPools() {
  constexpr int kEntries = 32;
  btDefaultCollisionConstructionInfo info;
  info.m_defaultMaxPersistentManifoldPoolSize = kEntries;
  info.m_defaultMaxCollisionAlgorithmPoolSize = kEntries;
  return info;
}

BulletScene::BulletScene(const BulletParameters& parameters, const Physics& physics)
    : Scene(parameters, physics),
      parameters_(parameters),
      configuration_(smallPools()),
      dispatcher_(&configuration_),
      world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
  world_.setGravity({0.0, 0.0, 0.0});
  world_.getSolverInfo().m_numIterations = static_cast<int>(parameters.iterations);
  world_.getSolverInfo().m_erp2 = parameters.overlap_rate * parameters.substep;
}

template <class Shape>
Shape* BulletScene::keep(std::unique_ptr<Shape> shape) {
  Shape* const kept = shape.get();
  shapes_.push_back(std::move(shape));
  return kept;
}

WorldState BulletScene::start(const WorldState& state) {
  // Bullet solves in the order in which bodies and constraints were added, and last bits depend on it.
  addTable();
  addWalls();
  addTee(state);
  addPusher(state);
  addTableFriction();
  return state;  // Bullet keeps a yaw as a matrix, which rounds it
}

void BulletScene::addTable() {
  btCollisionShape* shape = nullptr;
  if (parameters_.table_friction) {
    shape = keep(std::make_unique<btEmptyShape>());
  } else {
    const double margin = parameters_.margin ? 0.0 : CONVEX_DISTANCE_MARGIN;
    shape = keep(std::make_unique<btStaticPlaneShape>(btVector3(0.0, 0.0, 1.0), -(kTeeHalfHeight + margin)));
    shape->setMargin(0.0);
  }
  table_ = makeBody(0.0, 0.0, shape, at({0.0, 0.0, 0.0}), kInThePlane);
  table_->setContactProcessingThreshold(BT_LARGE_FLOAT);
}

void BulletScene::addWall(const PlacedBox& box) {
  btCollisionShape* const shape =
      keep(std::make_unique<btBoxShape>(btVector3(box.half_x, box.half_y, kWallHalfHeight)));
  walls_.push_back(makeBody(0.0, 0.0, shape, at({box.x, box.y, 0.0}), kInThePlane));
  world_.addRigidBody(walls_.back().get());
}

BulletScene::Body BulletScene::makeBody(double mass, double moment, btCollisionShape* shape, const btTransform& pose,
                                        const btVector3& linear) {
  // A moment of 0 is an infinite one to Bullet.
  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, {0.0, 0.0, moment});
  info.m_startWorldTransform = pose;
  info.m_friction = std::sqrt(physics().contact_friction);  // those of two bodies are multiplied
  auto body = std::make_unique<btRigidBody>(info);
  body->setLinearFactor(linear);
  body->setAngularFactor({0.0, 0.0, 1.0});
  if (parameters_.margin) {
    body->setContactProcessingThreshold(kTouch);
  }
  body->setFlags(0);  // no gyroscopic forces, which a body that turns about one axis does not have
  body->setActivationState(DISABLE_DEACTIVATION);
  return body;
}

btCollisionShape* BulletScene::addHull(double half_x, double half_y) {
  auto hull = std::make_unique<btConvexHullShape>();
  double inside = 0.0;  // [m] how far the corners are within the box, so that its faces are where they should be
  if (parameters_.margin) {
    hull->setMargin(kTeeMargin);
    inside = kTeeMargin;
  }
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) {
        hull->addPoint({x * (half_x - inside), y * (half_y - inside), z * (kTeeHalfHeight - inside)}, false);
      }
    }
  }
  hull->recalcLocalAabb();
  return keep(std::move(hull));
}

void BulletScene::addTee(const WorldState& state) {
  const TeeInertia inertia = teeInertia();
  center_ = inertia.center();
  btCompoundShape* const shape = keep(std::make_unique<btCompoundShape>());
  for (const PlacedBox& box : teeBoxes(physics())) {
    shape->addChildShape(at({box.x, center_ + box.y, 0.0}), addHull(box.half_x, box.half_y));
  }

  btTransform pose = at({0.0, 0.0, 0.0}, state.tee_yaw);
  pose.setOrigin(toBullet(state.tee_position) - pose.getBasis() * btVector3(0.0, center_, 0.0));
  const bool lies = !parameters_.table_friction;
  tee_ =
      makeBody(inertia.mass, inertia.momentAboutCenter(), shape, pose, lies ? btVector3(1.0, 1.0, 1.0) : kInThePlane);
  const btVector3 turning(0.0, 0.0, state.tee_yaw_rate);
  tee_->setAngularVelocity(turning);
  tee_->setLinearVelocity(toBullet(state.tee_velocity) - turning.cross(teeArm({0.0, 0.0})));
  if (lies) {
    tee_->setContactProcessingThreshold(BT_LARGE_FLOAT);  // or it would fall and be lifted in turn
  }
  if (!parameters_.drag) {
    tee_->setDamping(dampingOf(physics().tee_damping / inertia.mass),
                     dampingOf(physics().tee_yaw_damping / inertia.momentAboutCenter()));
  }
  world_.addRigidBody(tee_.get());
}

void BulletScene::addPusher(const WorldState& state) {
  btCollisionShape* const shape = keep(std::make_unique<btCylinderShapeZ>(
      btVector3(physics().pusher_radius, physics().pusher_radius, kPusherHalfHeight)));
  pusher_ = makeBody(pusherMass(), 0.0, shape, at(toBullet(state.pusher_position)), kInThePlane);
  pusher_->setLinearVelocity(toBullet(state.pusher_velocity));
  world_.addRigidBody(pusher_.get(), btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter ^ kTableGroup);
  if (!parameters_.servo) {
    pusher_motors_ = addMotors(*pusher_, at({0.0, 0.0, 0.0}), {physics().servo_limit, physics().servo_limit});
  }
}

BulletScene::Motors* BulletScene::addMotors(btRigidBody& body, const btTransform& frame,
                                            const std::array<double, 2>& force) {
  motors_.push_back(std::make_unique<Motors>(*table_, body, at({0.0, 0.0, 0.0}), frame));
  Motors& motors = *motors_.back();
  motors.setLinearLowerLimit({1.0, 1.0, 1.0});  // above the upper ones: none
  motors.setLinearUpperLimit({-1.0, -1.0, -1.0});
  for (const int axis : {0, 1}) {
    motors.enableMotor(axis, true);
    motors.setMaxMotorForce(axis, force[static_cast<std::size_t>(axis)]);
  }
  world_.addConstraint(&motors);
  return &motors;
}

void BulletScene::addFrictionPerAxis(const Eigen::Vector2d& point) {
  constexpr int kYaw = 5;
  Motors* const motors = addMotors(*tee_, at(inTheBody(point)), physics().tee_friction);
  motors->enableMotor(kYaw, true);
  motors->setMaxMotorForce(kYaw, physics().tee_yaw_friction);
}

void BulletScene::addIdiomaticFriction() {
  // Bullet multiplies the coefficients of two bodies. The plane's makes friction the scene's in a straight slide.
  if (physics().contact_friction == 0.0) {
    throw InvalidInput("contact_friction 0.0: must be above 0 with table_friction false: Bullet's table is a contact");
  }
  const double weight = physics().tee_mass * kGravity;  // [N]
  table_->setFriction(physics().tee_friction[0] / (weight * std::sqrt(physics().contact_friction)));
  world_.addRigidBody(table_.get(), kTableGroup, btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter);
  tee_->setGravity({0.0, 0.0, -weight * tee_->getInvMass()});
}

btVector3 BulletScene::inTheBody(const Eigen::Vector2d& point) const {
  return toBullet(point) + btVector3(0.0, center_, 0.0);
}

btVector3 BulletScene::teeArm(const Eigen::Vector2d& point) const {
  return tee_->getWorldTransform().getBasis() * inTheBody(point);
}

void BulletScene::applyServo(const Eigen::Vector2d& command) {
  if (pusher_motors_ != nullptr) {
    for (const int axis : {0, 1}) {
      pusher_motors_->setTargetVelocity(axis, -command[axis]);  // of the table, seen from the pusher
    }
    return;
  }
  const btVector3& place = pusher_->getWorldTransform().getOrigin();
  const btVector3 speed = pusher_->getLinearVelocity();
  pusher_->applyCentralForce({pusherForce(physics(), command.x(), place.x(), speed.x()),
                              pusherForce(physics(), command.y(), place.y(), speed.y()), 0.0});
}

void BulletScene::applyDragAt(const Eigen::Vector2d& point) {
  const btVector3 arm = teeArm(point);
  tee_->applyForce(-physics().tee_damping * tee_->getVelocityInLocalPoint(arm), arm);
  tee_->applyTorque({0.0, 0.0, -physics().tee_yaw_damping * tee_->getAngularVelocity().z()});
}

void BulletScene::advance() { world_.stepSimulation(parameters_.substep, 0); }

WorldState BulletScene::state() const {
  const btTransform& pose = tee_->getWorldTransform();
  const btVector3 arm = teeArm({0.0, 0.0});
  WorldState state;
  state.pusher_position = toEigen(pusher_->getWorldTransform().getOrigin());
  state.pusher_velocity = toEigen(pusher_->getLinearVelocity());
  state.tee_position = toEigen(pose.getOrigin() + arm);
  state.tee_velocity = toEigen(tee_->getVelocityInLocalPoint(arm));
  state.tee_yaw = wrapAngle(std::atan2(pose.getBasis()[1][0], pose.getBasis()[0][0]));
  state.tee_yaw_rate = tee_->getAngularVelocity().z();
  return state;
}

std::string BulletScene::faultOfSpeeds() const {
  constexpr double kMostTurn = kPi / 4.0;  // [rad] in a substep
  const double rate = tee_->getAngularVelocity().z();
  if (std::abs(rate) * parameters_.substep <= kMostTurn) {
    return "";
  }
  return "tee_yaw_rate " + shortestText(rate) + " rad/s: must be within " +
         significantText(kMostTurn / parameters_.substep, 4) +
         " rad/s: Bullet turns a body by at most pi/4 in a substep";
}

}  // namespace pusht
