// SPDX-License-Identifier: BSD-3-Clause
#include "box2d_scene.hpp"

#include <array>
#include <cmath>
#include <utility>

#include "pusht_task/numbers.hpp"

namespace pusht {
namespace {

/// [1/m] The tee's sides are then 3 to 12 lengths, and the 0.005 lengths that bodies may overlap are 0.05 mm.
constexpr double kScale = 100.0;

/// [-] Parts of a substep, of which Box2D itself moves bodies for one. In a step it moves none by more than 2 lengths,
/// which would be at most 2 m/s.
constexpr double kParts = 32.0;

/// [kg] Mass of each slider, taken from the tee at its origin, where it slides along: a body without mass is not to be
/// had. It is about half of the tee's. The solver passes impulses on from body to body: in a sweep, all but a share of
/// the lighter body's mass in that of both is left over. With a light slider a tee that is to stop would turn back.
constexpr double kSliderMass = 0.05;

/// Nearest yaw in [-pi, pi) of single precision, which rounds the numbers next to pi beyond it.
float narrowYaw(double yaw) {
  const auto narrow = static_cast<float>(yaw);
  return std::abs(static_cast<double>(narrow)) < kPi ? narrow : std::nextafter(narrow, 0.0F);
}

}  // namespace

Box2dScene::Box2dScene(const Box2dParameters& parameters, const Physics& physics)
    : Scene(parameters, physics),
      parameters_(parameters),
      scale_(parameters.scale ? kScale : 1.0),
      step_(parameters.scale ? parameters.substep / kParts : parameters.substep),
      world_(b2Vec2_zero) {
  world_.SetAllowSleeping(false);
  world_.SetContinuousPhysics(false);
}

b2Vec2 Box2dScene::toBox2d(const Eigen::Vector2d& vector) const {
  return {static_cast<float>(vector.x() * scale_), static_cast<float>(vector.y() * scale_)};
}

Eigen::Vector2d Box2dScene::toEigen(const b2Vec2& vector) const {
  return {static_cast<double>(vector.x) / scale_, static_cast<double>(vector.y) / scale_};
}

WorldState Box2dScene::start(const WorldState& state) {
  // Box2D solves in the order in which bodies, shapes and joints were added, and last bits depend on it.
  const b2BodyDef still;
  table_ = world_.CreateBody(&still);
  addWalls();
  addPusher(state);
  addTee(state);
  addTableFriction();
  return rounded(state);
}

b2Body* Box2dScene::addBody(const char* name, b2BodyDef def, double mass) {
  def.type = b2_dynamicBody;
  b2Body* const body = world_.CreateBody(&def);
  b2MassData data = {};
  data.mass = static_cast<float>(mass);
  data.center.SetZero();  // a vector of Box2D has no value by itself
  body->SetMassData(&data);
  bodies_.push_back({name, body});
  return body;
}

void Box2dScene::addPusher(const WorldState& state) {
  b2BodyDef def;
  def.position = toBox2d(state.pusher_position);
  def.linearVelocity = toBox2d(state.pusher_velocity);
  def.fixedRotation = true;
  pusher_ = addBody("pusher", def, pusherMass());
  b2CircleShape disc;
  disc.m_radius = static_cast<float>(physics().pusher_radius * scale_);
  b2FixtureDef fixture;
  fixture.shape = &disc;
  fixture.friction = static_cast<float>(physics().contact_friction);
  pusher_->CreateFixture(&fixture);
  if (!parameters_.servo) {
    addMotor();
  }
}

void Box2dScene::addMotor() {
  b2MotorJointDef def;
  def.Initialize(table_, pusher_);
  def.maxForce = force(physics().servo_limit);
  def.maxTorque = 0.0F;
  def.correctionFactor = 1.0F;
  def.collideConnected = true;
  motor_ = static_cast<b2MotorJoint*>(world_.CreateJoint(&def));  // NOLINT: Box2D knows no other way
}

void Box2dScene::addTee(const WorldState& state) {
  b2BodyDef def;
  def.position = toBox2d(state.tee_position);
  def.linearVelocity = toBox2d(state.tee_velocity);
  def.angle = narrowYaw(state.tee_yaw);
  def.angularVelocity = static_cast<float>(state.tee_yaw_rate);
  TeeInertia inertia = teeInertia();
  if (!parameters_.drag) {
    def.linearDamping = rate(physics().tee_damping / inertia.mass);
    def.angularDamping = rate(physics().tee_yaw_damping / inertia.momentAbout(physics().table_point));
  }
  if (parameters_.table_friction) {
    inertia.mass -= kSliderMass;
  }
  tee_ = addBody("tee", def, inertia.mass);
  for (const PlacedBox& box : teeBoxes(physics())) {
    addBox(tee_, box);
  }
  b2MassData data;
  data.mass = static_cast<float>(inertia.mass);
  data.center.Set(0.0F, static_cast<float>(-inertia.center() * scale_));
  data.I = static_cast<float>(inertia.second_moment * scale_ * scale_);
  tee_->SetMassData(&data);  // hands the velocity from the origin to the center of mass
}

void Box2dScene::addBox(b2Body* body, const PlacedBox& box) {
  const double skin = parameters_.scale ? static_cast<double>(b2_polygonRadius) : 0.0;
  b2PolygonShape shape;
  shape.SetAsBox(static_cast<float>(box.half_x * scale_ - skin), static_cast<float>(box.half_y * scale_ - skin),
                 toBox2d({box.x, box.y}), 0.0F);
  b2FixtureDef fixture;
  fixture.shape = &shape;
  fixture.friction = static_cast<float>(physics().contact_friction);
  body->CreateFixture(&fixture);
}

void Box2dScene::addIdiomaticFriction() { addFrictionOfDisc(toEigen(tee_->GetLocalCenter())); }

void Box2dScene::addFrictionPerAxis(const Eigen::Vector2d& point) {
  const b2Vec2 local = toBox2d(point);
  addSlider({1.0F, 0.0F}, local, physics().tee_friction[0], physics().tee_yaw_friction);
  addSlider({0.0F, 1.0F}, local, physics().tee_friction[1], 0.0);
}

void Box2dScene::addSlider(const b2Vec2& axis, const b2Vec2& point, double friction, double yaw_friction) {
  const b2Vec2 velocity = tee_->GetLinearVelocityFromLocalPoint(point);
  b2BodyDef def;
  def.position = b2Dot(tee_->GetWorldPoint(point), axis) * axis;
  def.linearVelocity = b2Dot(velocity, axis) * axis;
  def.linearDamping = tee_->GetLinearDamping();
  def.fixedRotation = true;
  b2Body* const slider = addBody("tee's slider", def, kSliderMass);

  b2PrismaticJointDef rail;
  rail.bodyA = table_;
  rail.bodyB = slider;
  rail.localAxisA = axis;
  rail.enableMotor = true;
  rail.maxMotorForce = force(friction);
  world_.CreateJoint(&rail);

  b2WheelJointDef across;
  across.bodyA = slider;
  across.bodyB = tee_;
  across.localAxisA = b2Vec2(-axis.y, axis.x);
  across.localAnchorB = point;
  across.enableMotor = yaw_friction > 0.0;
  across.maxMotorTorque = moment(yaw_friction);
  world_.CreateJoint(&across);
}

void Box2dScene::addFrictionOfDisc(const Eigen::Vector2d& point) {
  b2FrictionJointDef disc;
  disc.bodyA = table_;
  disc.bodyB = tee_;
  disc.localAnchorB = toBox2d(point);
  disc.maxForce = force(physics().tee_friction[0]);
  disc.maxTorque = moment(physics().tee_yaw_friction);
  disc.collideConnected = true;  // the table has the walls
  world_.CreateJoint(&disc);
}

void Box2dScene::applyServo(const Eigen::Vector2d& command) {
  if (motor_ != nullptr) {
    motor_->SetLinearOffset(pusher_->GetPosition() + toBox2d(step_ * command));
    return;
  }
  const Eigen::Vector2d place = toEigen(pusher_->GetPosition());
  const Eigen::Vector2d speed = toEigen(pusher_->GetLinearVelocity());
  pusher_->ApplyForceToCenter({force(pusherForce(physics(), command.x(), place.x(), speed.x())),
                               force(pusherForce(physics(), command.y(), place.y(), speed.y()))},
                              true);
}

void Box2dScene::applyDragAt(const Eigen::Vector2d& point) {
  const b2Vec2 local = toBox2d(point);
  const Eigen::Vector2d velocity = toEigen(tee_->GetLinearVelocityFromLocalPoint(local));
  const Eigen::Vector2d drag = -physics().tee_damping * velocity;
  tee_->ApplyForce({force(drag.x()), force(drag.y())}, tee_->GetWorldPoint(local), true);
  tee_->ApplyTorque(moment(-physics().tee_yaw_damping * static_cast<double>(tee_->GetAngularVelocity())), true);
}

void Box2dScene::advance() {
  world_.Step(static_cast<float>(step_), static_cast<int>(parameters_.velocity_iterations),
              static_cast<int>(parameters_.position_iterations));
  if (const double rest = parameters_.substep - step_; rest > 0.0) {
    for (const NamedBody& each : bodies_) {
      moveOn(*each.body, static_cast<float>(rest));
    }
  }
}

void Box2dScene::moveOn(b2Body& body, float time) {
  const float angle = body.GetAngle() + time * body.GetAngularVelocity();
  const b2Vec2 center = body.GetWorldCenter() + time * body.GetLinearVelocity();
  body.SetTransform(center - b2Mul(b2Rot(angle), body.GetLocalCenter()), angle);
}

WorldState Box2dScene::state() const {
  WorldState state;
  state.pusher_position = toEigen(pusher_->GetPosition());
  state.pusher_velocity = toEigen(pusher_->GetLinearVelocity());
  state.tee_position = toEigen(tee_->GetPosition());
  state.tee_velocity = toEigen(tee_->GetLinearVelocityFromLocalPoint(b2Vec2_zero));
  state.tee_yaw = wrapAngle(static_cast<double>(tee_->GetAngle()));
  state.tee_yaw_rate = static_cast<double>(tee_->GetAngularVelocity());
  return state;
}

WorldState Box2dScene::rounded(const WorldState& state) const {
  WorldState result;
  result.pusher_position = roundedVector(state.pusher_position);
  result.pusher_velocity = roundedVector(state.pusher_velocity);
  result.tee_position = roundedVector(state.tee_position);
  result.tee_velocity = roundedVector(state.tee_velocity);
  result.tee_yaw = static_cast<double>(narrowYaw(state.tee_yaw));
  result.tee_yaw_rate = static_cast<double>(static_cast<float>(state.tee_yaw_rate));
  return result;
}

std::string Box2dScene::faultOfPositions(const WorldState& state) const {
  const std::array<std::pair<const char*, double>, 4> coordinates = {{{"pusher_x", state.pusher_position.x()},
                                                                      {"pusher_y", state.pusher_position.y()},
                                                                      {"tee_x", state.tee_position.x()},
                                                                      {"tee_y", state.tee_position.y()}}};
  for (const auto& [name, value] : coordinates) {
    if (!(std::abs(value) < kReach)) {
      return std::string(name) + " " + shortestText(value) + " m: must be within " + shortestText(kReach) +
             " m, as Box2D computes in single precision";
    }
  }
  return "";
}

std::string Box2dScene::faultOfSpeeds() const {
  constexpr double kNearly = 1.0 - 1e-5;  // Box2D cuts off what is more, and rounds
  const double most = static_cast<double>(b2_maxTranslation) / (scale_ * step_);  // [m/s]
  const double most_rate = static_cast<double>(b2_maxRotation) / step_;           // [rad/s]
  for (const NamedBody& each : bodies_) {
    const double rate = std::abs(static_cast<double>(each.body->GetAngularVelocity()));
    if (!(rate < kNearly * most_rate)) {
      return std::string(each.name) + " at " + shortestText(rate) + " rad/s: must be below " + shortestText(most_rate) +
             " rad/s, where Box2D cuts rates off";
    }
    const double speed = toEigen(each.body->GetLinearVelocity()).norm();
    if (!(speed < kNearly * most)) {
      return std::string(each.name) + " at " + shortestText(speed) + " m/s: must be below " + shortestText(most) +
             " m/s, where Box2D cuts speeds off";
    }
  }
  return "";
}

}  // namespace pusht
