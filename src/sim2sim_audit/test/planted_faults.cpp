// SPDX-License-Identifier: BSD-3-Clause
#include "planted_faults.hpp"

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "chipmunk_scene.hpp"
#include "coordinates.hpp"
#include "faulty.hpp"
#include "pusht_chipmunk/chipmunk_world.hpp"
#include "pusht_engine/rigid_body_engine.hpp"
#include "pusht_mujoco/mujoco_scene.hpp"
#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_task/physics.hpp"
#include "sim2sim_audit/experiments.hpp"

namespace sim2sim::testing {
namespace {

using pusht::Physics;
using pusht::WorldState;
using RigidModel = pusht::rigid_body::Model;
using P = Property;

// MuJoCo: fields of its compiled model.

/// [-] Moment about the center of mass of a tee whose stem is taken to be at the origin, over the task's.
double momentWithoutOffset() {
  const Physics task;
  const double of_offset = task.tee_mass * task.centerOfMass() * task.centerOfMass();
  const double forgotten = pusht::kStemMass * pusht::kStemOffset * pusht::kStemOffset;
  return (task.tee_second_moment - forgotten - of_offset) / (task.tee_second_moment - of_offset);
}

using ChangeMujoco = std::function<void(mjModel&)>;

std::shared_ptr<const pusht::MujocoScene> sceneWith(const ChangeMujoco& change) {
  auto scene = std::make_shared<pusht::MujocoScene>();
  auto& model = const_cast<mjModel&>(scene->model());  // NOLINT(cppcoreguidelines-pro-type-const-cast): a planted fault
  change(model);
  mjData* const data = mj_makeData(&model);
  mj_setConst(&model, data);
  mj_deleteData(data);
  return scene;
}

WorldFactory mujocoWith(const ChangeMujoco& change) {
  const auto scene = sceneWith(change);
  return [scene] { return std::make_unique<pusht::MujocoWorld>(scene); };
}

int geomOf(const mjModel& model, const char* name) { return mj_name2id(&model, mjOBJ_GEOM, name); }
int bodyOf(const mjModel& model, const char* name) { return mj_name2id(&model, mjOBJ_BODY, name); }

ChangeMujoco scaledGain(double factor) {
  return [factor](mjModel& model) {
    for (int actuator = 0; actuator < model.nu; ++actuator) {
      model.actuator_gainprm[mjNGAIN * actuator] *= factor;
      model.actuator_biasprm[mjNBIAS * actuator + 2] *= factor;
    }
  };
}

ChangeMujoco scaledLimit(double factor) {
  return [factor](mjModel& model) {
    for (int i = 0; i < 2 * model.nu; ++i) {
      model.actuator_forcerange[i] *= factor;
    }
  };
}

ChangeMujoco scaledDamping(std::initializer_list<int> coordinates, double factor) {
  return [of = std::vector<int>(coordinates), factor](mjModel& model) {
    for (const int coordinate : of) {
      model.dof_damping[coordinate] *= factor;
    }
  };
}

ChangeMujoco scaledFriction(std::initializer_list<int> coordinates, double factor) {
  return [of = std::vector<int>(coordinates), factor](mjModel& model) {
    for (const int coordinate : of) {
      model.dof_frictionloss[coordinate] *= factor;
    }
  };
}

ChangeMujoco scaledMass(const char* name, double factor, bool with_moment) {
  return [=](mjModel& model) {
    const int body = bodyOf(model, name);
    model.body_mass[body] *= factor;
    for (int i = 0; with_moment && i < 3; ++i) {
      model.body_inertia[3 * body + i] *= factor;
    }
  };
}

void shiftCenter(mjModel& model, double along_y) { model.body_ipos[3 * bodyOf(model, "tee") + 1] += along_y; }

void scaleMoment(mjModel& model, double factor) {
  for (int i = 0; i < 3; ++i) {
    model.body_inertia[3 * bodyOf(model, "tee") + i] *= factor;
  }
}

void moveGeom(mjModel& model, const char* name, int axis, double distance) {
  model.geom_pos[3 * geomOf(model, name) + axis] += distance;
}

/// A world of MuJoCo that counts its own substeps.
class MujocoOfSubsteps : public pusht::Simulator {
 public:
  /// `held`: substeps after which the command becomes 0.
  explicit MujocoOfSubsteps(int substeps, int held = pusht::kSubstepsPerControlStep)
      : Simulator("", pusht::MujocoWorld::kStartTolerance),
        substeps_(substeps),
        held_(held),
        data_(mj_makeData(&scene_.model())) {}

 private:
  struct DeleteData {
    void operator()(mjData* data) const { mj_deleteData(data); }
  };

  void doReset(const WorldState& state) override {
    mj_resetData(&scene_.model(), data_.get());
    const std::array<double, 5> positions = {state.tee_position.x(), state.tee_position.y(), state.tee_yaw,
                                             state.pusher_position.x(), state.pusher_position.y()};
    const std::array<double, 5> velocities = {state.tee_velocity.x(), state.tee_velocity.y(), state.tee_yaw_rate,
                                              state.pusher_velocity.x(), state.pusher_velocity.y()};
    std::copy(positions.begin(), positions.end(), data_->qpos);
    std::copy(velocities.begin(), velocities.end(), data_->qvel);
    mj_forward(&scene_.model(), data_.get());
  }
  void doStep(const pusht::Action& action) override {
    std::copy(action.begin(), action.end(), data_->ctrl);
    for (int i = 0; i < substeps_; ++i) {
      if (i == held_) {
        mju_zero(data_->ctrl, scene_.model().nu);
      }
      mj_step(&scene_.model(), data_.get());
    }
  }
  WorldState doState() const override {
    const mjtNum* const q = data_->qpos;
    const mjtNum* const v = data_->qvel;
    return {{q[3], q[4]}, {v[3], v[4]}, {q[0], q[1]}, {v[0], v[1]}, pusht::wrapAngle(q[2]), v[2]};
  }

  pusht::MujocoScene scene_;
  int substeps_;
  int held_;
  std::unique_ptr<mjData, DeleteData> data_;
};

// Chipmunk: numbers of its scene, and laws.

using ChangePhysics = std::function<void(Physics&)>;

WorldFactory chipmunkWith(const ChangePhysics& change) {
  Physics physics;
  change(physics);
  return [physics] {
    return std::make_unique<pusht::ChipmunkWorld>(
        [physics] { return std::make_unique<pusht::chipmunk::Scene>(pusht::ChipmunkParameters(), physics); });
  };
}

ChangePhysics scaled(double Physics::*number, double factor) {
  return [=](Physics& physics) { physics.*number *= factor; };
}

/// The tee's moment about its origin, of a moment about the center of mass that is so many times the task's.
void scaleMomentAboutCenter(Physics& physics, double factor) {
  const double of_offset = physics.tee_mass * physics.centerOfMass() * physics.centerOfMass();
  physics.tee_second_moment = of_offset + factor * (physics.tee_second_moment - of_offset);
}

/// Shifts the center of mass, and keeps the moment about it.
void shiftCenterOf(Physics& physics, double along_minus_y) {
  const double before = physics.centerOfMass();
  const double after = before + along_minus_y;
  physics.tee_first_moment = physics.tee_mass * after;
  physics.tee_second_moment += physics.tee_mass * (after * after - before * before);
}

/// Friction and damping at the center of mass, as engines have them ready-made.
struct DragAtTheCenter : pusht::chipmunk::Scene {
  explicit DragAtTheCenter(const pusht::ChipmunkParameters& parameters) : Scene(parameters, moved(parameters)) {}

  /// The mass that makes the damping implicit sits where the damping acts.
  static Physics moved(const pusht::ChipmunkParameters& parameters) {
    Physics physics;
    const double added = parameters.substep * physics.tee_damping;  // [kg]
    physics.tee_first_moment += added * pusht::kCenterOfMassOffset;
    physics.tee_second_moment += added * pusht::kCenterOfMassOffset * pusht::kCenterOfMassOffset;
    return physics;
  }
  void addDryFriction() override {
    const cpVect center = cpv(0.0, -pusht::kCenterOfMassOffset);
    const double far = 1000.0;  // [m]
    addFriction(cpGrooveJointNew(table(), tee(), cpv(0.0, -far), cpv(0.0, far), center), physics().tee_friction[0]);
    addFriction(cpGrooveJointNew(table(), tee(), cpv(-far, 0.0), cpv(far, 0.0), center), physics().tee_friction[1]);
    addFriction(cpSimpleMotorNew(table(), tee(), 0.0), physics().tee_yaw_friction);
  }
  void applyForces(const cpVect& command) override {
    applyServo(command);
    cpBodySetForce(tee(), cpvmult(cpBodyGetVelocity(tee()), -physics().tee_damping));
    cpBodySetTorque(tee(), -physics().tee_yaw_damping * cpBodyGetAngularVelocity(tee()));
  }
};

/// Friction of the table with one limit in all directions.
struct FrictionOfADisc : pusht::chipmunk::Scene {
  using Scene::Scene;
  void addDryFriction() override {
    addFriction(cpPivotJointNew2(table(), tee(), cpvzero, cpvzero), physics().tee_friction[0]);
    addFriction(cpSimpleMotorNew(table(), tee(), 0.0), physics().tee_yaw_friction);
  }
};

/// Contacts that give half of the velocity back.
struct Bouncing : pusht::chipmunk::Scene {
  using Scene::Scene;
  void applyForces(const cpVect& command) override {
    const auto set = [](cpShape* shape, void* /*none*/) {
      cpShapeSetElasticity(shape, std::sqrt(0.5));  // Chipmunk multiplies those of two shapes
    };
    cpSpaceEachShape(cpBodyGetSpace(tee()), set, nullptr);
    Scene::applyForces(command);
  }
};

/// One wall 5 mm too far out.
struct WallTooFar : pusht::chipmunk::Scene {
  using Scene::Scene;
  void addWalls() override {
    const double half = 0.5 * pusht::dynamics::kWallThickness;
    const double middle = physics().wall_inner_face + half;
    const double long_half = middle + half;
    addBox(table(), cpv(0.0, middle), long_half, half);
    addBox(table(), cpv(0.0, -middle), long_half, half);
    addBox(table(), cpv(middle + 0.005, 0.0), half, long_half);
    addBox(table(), cpv(-middle, 0.0), half, long_half);
  }
};

template <class FaultyScene>
WorldFactory chipmunkOf() {
  return [] {
    return std::make_unique<pusht::ChipmunkWorld>(
        [] { return std::make_unique<FaultyScene>(pusht::ChipmunkParameters()); });
  };
}

/// A world of Chipmunk that counts its own substeps.
class ChipmunkOfSubsteps : public pusht::Simulator {
 public:
  /// `held`: substeps after which the command becomes 0.
  explicit ChipmunkOfSubsteps(int substeps, int held = pusht::kSubstepsPerControlStep)
      : Simulator("", pusht::ChipmunkWorld::kStartTolerance), substeps_(substeps), held_(held) {}

 private:
  void doReset(const WorldState& state) override {
    scene_ = std::make_unique<pusht::chipmunk::Scene>(pusht::ChipmunkParameters());
    scene_->start(state);
  }
  void doStep(const pusht::Action& action) override {
    for (int i = 0; i < substeps_; ++i) {
      scene_->substep(i < held_ ? cpv(action[0], action[1]) : cpvzero);
    }
  }
  WorldState doState() const override { return scene_->state(); }

  int substeps_;
  int held_;
  std::unique_ptr<pusht::chipmunk::Scene> scene_;
};

// Rigid body: constants of its substep.

using ChangeRigid = std::function<void(RigidModel&)>;

/// The engine with other constants, and another number of substeps.
struct PlantedPhysics : pusht::RigidBodyPhysics {
  struct Parameters {
    ChangeRigid change = [](RigidModel&) {};
    int substeps = pusht::kSubstepsPerControlStep;
  };
  struct Model : RigidModel {
    int substeps;
  };

  static Model modelOf(const Parameters& parameters) {
    Model model = {pusht::rigid_body::modelOf({}), parameters.substeps};
    parameters.change(model);
    return model;
  }
  static int substepsOf(const Model& model) { return model.substeps; }
  static void substep(const Model& model, const Eigen::Vector2d& command, Bodies& bodies) {
    pusht::rigid_body::substep(model, command, bodies);
  }
};
using PlantedEngine = pusht::PlanarSimulator<PlantedPhysics>;

WorldFactory rigidWith(const ChangeRigid& change, int substeps = pusht::kSubstepsPerControlStep) {
  return [=] { return std::make_unique<PlantedEngine>(PlantedPhysics::Parameters{change, substeps}); };
}

ChangeRigid scaled(double RigidModel::*number, double factor) {
  return [=](RigidModel& model) { model.*number *= factor; };
}

ChangeRigid rigidServo(double gain_factor, double damping_factor) {
  return [=](RigidModel& model) {
    model.servo_gain *= gain_factor;
    model.pusher_damping *= damping_factor;
    model.servo_derivative = model.servo_gain + model.pusher_damping;
  };
}

/// The tee's moment about its origin, of a moment about the center of mass that is so many times the task's.
void scaleRigidMoment(RigidModel& model, double factor) {
  const double of_offset = model.tee_mass * pusht::kCenterOfMassOffset * pusht::kCenterOfMassOffset;
  model.tee_moment = of_offset + factor * (model.tee_moment - of_offset);
}

// Interfaces.

PlantedFault atTheInterface(std::string name, std::vector<Property> named_by, const InterfaceFault& fault) {
  const auto over = [fault](const WorldFactory& make) -> WorldFactory {
    return [=] { return std::make_unique<Faulty>(make(), fault); };
  };
  return {std::move(name), std::move(named_by), over(cleanMujoco()), over(cleanChipmunk()), over(cleanRigidBody())};
}

/// Fault of what a state says, read and written in the same wrong way.
InterfaceFault both(InterfaceFault::OfState start, InterfaceFault::OfState report) {
  InterfaceFault fault;
  fault.start = std::move(start);
  fault.report = std::move(report);
  return fault;
}

InterfaceFault ofCommands(InterfaceFault::OfAction command) {
  InterfaceFault fault;
  fault.command = std::move(command);
  return fault;
}

InterfaceFault::OfState velocitiesTimes(double factor) {
  return [factor](WorldState state) {
    state.pusher_velocity *= factor;
    state.tee_velocity *= factor;
    state.tee_yaw_rate *= factor;
    return state;
  };
}

InterfaceFault::OfState yawTimes(double factor) {
  return [factor](WorldState state) {
    state.tee_yaw = pusht::wrapAngle(factor * state.tee_yaw);
    state.tee_yaw_rate *= factor;
    return state;
  };
}

InterfaceFault::OfState yawPlus(double offset) {
  return [offset](WorldState state) {
    state.tee_yaw = pusht::wrapAngle(state.tee_yaw + offset);
    return state;
  };
}

const Eigen::Vector2d kCenterOfMass(0.0, -pusht::kCenterOfMassOffset);  // [m] body frame

InterfaceFault::OfState placeOf(const Eigen::Vector2d& point) {
  return [point](const WorldState& state) { return movedTo(state, point); };
}

/// The tee's velocity plus that of a point against the origin's.
InterfaceFault::OfState velocityOf(const Eigen::Vector2d& point) {
  return [point](WorldState state) {
    state.tee_velocity = movedTo(state, point).tee_velocity;
    return state;
  };
}

InterfaceFault::OfState velocityTurned(double times_yaw) {
  return [times_yaw](WorldState state) {
    state.tee_velocity = Eigen::Rotation2Dd(times_yaw * state.tee_yaw) * state.tee_velocity;
    return state;
  };
}

WorldState pusherVelocitySwapped(WorldState state) {
  std::swap(state.pusher_velocity.x(), state.pusher_velocity.y());
  return state;
}

/// The tee's position and velocity along other axes: a world in which the table is elsewhere.
InterfaceFault::OfState tableMoved(const Eigen::Vector2d& by) {
  return [by](WorldState state) {
    state.tee_position += by;
    state.pusher_position += by;
    return state;
  };
}

std::vector<PlantedFault> interfaceFaults() {
  InterfaceFault late;
  late.delay = 1;
  InterfaceFault very_late;
  very_late.delay = 2;
  InterfaceFault stale;
  stale.stale = true;
  InterfaceFault noisy;
  noisy.noise = 1e-4;
  InterfaceFault leaking;
  leaking.leak = 0.02;
  InterfaceFault warm;
  warm.leak = 1e-6;
  InterfaceFault projecting;
  projecting.start = [](WorldState state) {
    state.tee_yaw_rate = std::max(-5.0, std::min(5.0, state.tee_yaw_rate));
    return state;
  };
  const double degree = pusht::kPi / 180.0;
  using A = pusht::Action;
  const std::vector<Property> of_velocities = {P::kPusherVelocityFactor, P::kTeeVelocityFactor, P::kYawRateFactor};
  const std::vector<Property> of_axes = {P::kAxesTurn, P::kAxesMirror};
  return {
      atTheInterface("delay of one step", {P::kDelay}, late),
      atTheInterface("delay of two steps", {P::kDelay}, very_late),
      atTheInterface("stale state", {P::kStaleSteps}, stale),
      atTheInterface("action times 0.9", {P::kActionScaleX, P::kActionScaleY}, ofCommands([](const A& a) {
                       return A{0.9F * a[0], 0.9F * a[1]};
                     })),
      atTheInterface("action times 0.9 along y", {P::kActionScaleY}, ofCommands([](const A& a) {
                       return A{a[0], 0.9F * a[1]};
                     })),
      atTheInterface("axes of the action swapped", of_axes, ofCommands([](const A& a) {
                       return A{a[1], a[0]};
                     })),
      atTheInterface("y of the action mirrored", of_axes, ofCommands([](const A& a) {
                       return A{a[0], -a[1]};
                     })),
      atTheInterface("clip at 0.9", {P::kActionLimit}, ofCommands([](const A& a) {
                       return A{std::max(-0.9F, std::min(0.9F, a[0])), std::max(-0.9F, std::min(0.9F, a[1]))};
                     })),
      atTheInterface("action off by 0.05 along x", {P::kRestMotion}, ofCommands([](const A& a) {
                       return A{a[0] + 0.05F, a[1]};
                     })),
      atTheInterface("dead band of 0.03", {P::kSmallCommand}, ofCommands([](const A& a) {
                       return A{std::abs(a[0]) < 0.03F ? 0.0F : a[0], std::abs(a[1]) < 0.03F ? 0.0F : a[1]};
                     })),
      atTheInterface("axes of the pusher's velocity swapped", {P::kPusherVelocityFactor},
                     both(pusherVelocitySwapped, pusherVelocitySwapped)),
      atTheInterface("sense of the yaw", {P::kYawGain}, both(yawTimes(-1.0), yawTimes(-1.0))),
      atTheInterface("yaw off by 0.1", {P::kYawOffset}, both(yawPlus(-0.1), yawPlus(0.1))),
      atTheInterface("yaw in degrees", {P::kYawGain}, both(yawTimes(degree), yawTimes(1.0 / degree))),
      atTheInterface("origin at the center of mass", {P::kOriginY},
                     both(placeOf(-kCenterOfMass), placeOf(kCenterOfMass))),
      atTheInterface("velocity of the center of mass", {P::kTeeVelocityPoint},
                     both(velocityOf(-kCenterOfMass), velocityOf(kCenterOfMass))),
      atTheInterface("velocity in body axes", {P::kTeeVelocityFrame}, both(velocityTurned(1.0), velocityTurned(-1.0))),
      atTheInterface("velocities times 2", of_velocities, both(velocitiesTimes(0.5), velocitiesTimes(2.0))),
      atTheInterface("reported velocities times 2", of_velocities,
                     both([](const WorldState& s) { return s; }, velocitiesTimes(2.0))),
      atTheInterface("table off by 5 mm", {P::kWallRight, P::kWallLeft},
                     both(tableMoved({-0.005, 0.0}), tableMoved({0.005, 0.0}))),
      atTheInterface("state that leaks over a reset", {P::kLeak}, leaking),
      atTheInterface("warm start that leaks", {P::kLeak}, warm),
      atTheInterface("noise of 1e-4", {P::kNoise}, noisy),
      atTheInterface("start that is quietly projected", {P::kStartYawRate}, projecting),
  };
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
      {"dry friction of the pusher, 1 N",
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
      {"dry friction of a disc", {P::kFrictionShape}, {}, chipmunkOf<FrictionOfADisc>(), {}},
      {"dry friction doubled", of_friction, mujocoWith(scaledFriction({kTeeX, kTeeY, kTeeYaw}, 2.0)),
       chipmunkWith(friction(2.0)), rigidWith(rigid_friction(2.0))},
      {"dry friction missing", of_friction, mujocoWith(scaledFriction({kTeeX, kTeeY, kTeeYaw}, 0.0)),
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
       chipmunkWith(scaled(&Physics::contact_friction, std::sqrt(0.5))),
       {}},
      {"contact friction missing",
       {P::kContactFriction},
       mujocoWith(friction(1e-3)),
       chipmunkWith(scaled(&Physics::contact_friction, 0.0)),
       rigidWith([](RigidModel& m) { m.switches.friction = false; })},
      {"restitution 0.5", {P::kHit, P::kHiddenState}, {}, chipmunkOf<Bouncing>(), {}},
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
  return [] { return std::make_unique<pusht::ChipmunkWorld>(); };
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
