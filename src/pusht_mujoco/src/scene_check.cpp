// SPDX-License-Identifier: BSD-3-Clause
#include "scene_check.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

// What the reference adds to the task: the numbers of the scene, SI units.
constexpr double kTeeDamping = 4.0;          // [N s/m]
constexpr double kTeeFriction = 1.2;         // [N]
constexpr double kTeeYawDamping = 0.02;      // [N m s]
constexpr double kTeeYawFriction = 0.006;    // [N m]
constexpr double kPusherDamping = 0.5;       // [N s/m]
constexpr double kPusherMass = 0.2;          // [kg]
constexpr double kPusherHalfHeight = 0.02;   // [m]
constexpr double kServoGain = 20.0;          // [N s/m]
constexpr double kServoForce = 30.0;         // [N]
constexpr double kTeeHeight = 0.0152;        // [m]
constexpr double kPusherHeight = 0.02;       // [m]
constexpr double kWallHalfThickness = 0.02;  // [m]
constexpr double kWallHalfLength = 0.43;     // [m]
constexpr double kWallHalfHeight = 0.03;     // [m]

/// Relative difference below which a number is the expected one.
constexpr double kTolerance = 1e-9;

void expect(const std::string& field, double value, double expected) {
  // Written so that a NaN fails.
  if (!(std::abs(value - expected) <= kTolerance * std::max(1.0, std::abs(expected)))) {
    std::ostringstream message;
    message.precision(10);
    message << field << " is " << value << ": must be " << expected;
    throw InvalidInput(message.str());
  }
}

template <class Number>
void expect(const std::string& field, const Number* values, const std::vector<double>& expected) {
  for (std::size_t i = 0; i < expected.size(); ++i) {
    expect(field + "[" + std::to_string(i) + "]", static_cast<double>(values[i]), expected[i]);
  }
}

void expectName(const mjModel& model, int type, int id, const std::string& what, const std::string& expected) {
  const char* name = mj_id2name(&model, type, id);
  const std::string found = name == nullptr ? "" : name;
  if (found != expected) {
    throw InvalidInput(what + " " + std::to_string(id) + " is '" + found + "': must be '" + expected + "'");
  }
}

void checkOptions(const mjOption& option) {
  expect("option timestep", option.timestep, kSubstep);
  expect("option integrator", option.integrator, mjINT_IMPLICIT);
  expect("option cone", option.cone, mjCONE_PYRAMIDAL);
  expect("option solver", option.solver, mjSOL_NEWTON);
  expect("option iterations", option.iterations, 100);
  expect("option tolerance", option.tolerance, 1e-8);
  expect("option noslip_iterations", option.noslip_iterations, 0);
  expect("option noslip_tolerance", option.noslip_tolerance, 1e-6);
  expect("option mpr_iterations", option.mpr_iterations, 50);
  expect("option mpr_tolerance", option.mpr_tolerance, 1e-6);
  expect("option jacobian", option.jacobian, mjJAC_AUTO);
  expect("option collision", option.collision, mjCOL_ALL);
  expect("option impratio", option.impratio, 1);
  expect("option gravity", option.gravity, {0, 0, -9.81});
  expect("option wind", option.wind, {0, 0, 0});
  expect("option density", option.density, 0);
  expect("option viscosity", option.viscosity, 0);
  expect("option disableflags", option.disableflags, 0);
  expect("option enableflags", option.enableflags, 0);
}

void checkSizes(const mjModel& model) {
  expect("number of bodies", model.nbody, 3);
  expect("number of joints", model.njnt, 5);
  expect("number of coordinates", model.nq, 5);
  expect("number of degrees of freedom", model.nv, 5);
  expect("number of actuators", model.nu, 2);
  expect("number of activations", model.na, 0);
  expect("number of equality constraints", model.neq, 0);
  expect("number of tendons", model.ntendon, 0);
  expect("number of contact pairs", model.npair, 0);
  expect("number of contact exclusions", model.nexclude, 0);
}

struct Joint {
  std::string name;
  int type;
  int body;
  std::vector<double> axis;
  double damping;
  double friction;
  double inertia;  // [kg] or [kg m^2] about the joint, at the initial pose
};

void checkJoints(const mjModel& model) {
  constexpr double kTeeMass = kBarMass + kStemMass;
  constexpr double kWidthSquared = kTeeHalfWidth * kTeeHalfWidth;
  constexpr double kBarInertia = kBarMass / 3.0 * (kBarHalfLength * kBarHalfLength + kWidthSquared);
  constexpr double kStemInertia = kStemMass / 3.0 * (kStemHalfLength * kStemHalfLength + kWidthSquared);
  constexpr double kTeeInertia = kBarInertia + kStemInertia + kStemMass * kStemOffset * kStemOffset;
  const std::array<Joint, 5> joints = {
      Joint{"tee_x", mjJNT_SLIDE, 1, {1, 0, 0}, kTeeDamping, kTeeFriction, kTeeMass},
      Joint{"tee_y", mjJNT_SLIDE, 1, {0, 1, 0}, kTeeDamping, kTeeFriction, kTeeMass},
      Joint{"tee_yaw", mjJNT_HINGE, 1, {0, 0, 1}, kTeeYawDamping, kTeeYawFriction, kTeeInertia},
      Joint{"pusher_x", mjJNT_SLIDE, 2, {1, 0, 0}, kPusherDamping, 0.0, kPusherMass},
      Joint{"pusher_y", mjJNT_SLIDE, 2, {0, 1, 0}, kPusherDamping, 0.0, kPusherMass}};
  for (int i = 0; i < model.njnt; ++i) {
    const Joint& joint = joints.at(static_cast<std::size_t>(i));
    expectName(model, mjOBJ_JOINT, i, "joint", joint.name);
    const std::string field = "joint " + joint.name + " ";
    expect(field + "type", model.jnt_type[i], joint.type);
    expect(field + "body", model.jnt_bodyid[i], joint.body);
    expect(field + "axis", model.jnt_axis + 3 * i, joint.axis);
    expect(field + "pos", model.jnt_pos + 3 * i, {0, 0, 0});
    expect(field + "limited", model.jnt_limited[i], 0);
    expect(field + "stiffness", model.jnt_stiffness[i], 0);
    expect(field + "ref", model.qpos0[i], 0);
    expect(field + "armature", model.dof_armature[i], 0);
    expect(field + "damping", model.dof_damping[i], joint.damping);
    expect(field + "frictionloss", model.dof_frictionloss[i], joint.friction);
    expect(field + "inertia", model.dof_M0[i], joint.inertia);
    expect(field + "solreffriction", model.dof_solref + mjNREF * i, {0.02, 1});
    expect(field + "solimpfriction", model.dof_solimp + mjNIMP * i, {0.9, 0.95, 0.001, 0.5, 2});
  }
}

void checkBodies(const mjModel& model) {
  expectName(model, mjOBJ_BODY, 1, "body", "tee");
  expectName(model, mjOBJ_BODY, 2, "body", "pusher");
  expect("body tee pos", model.body_pos + 3, {0, 0, kTeeHeight});
  expect("body pusher pos", model.body_pos + 6, {0, 0, kPusherHeight});
  expect("body tee quat", model.body_quat + 4, {1, 0, 0, 0});
  expect("body pusher quat", model.body_quat + 8, {1, 0, 0, 0});
  expect("body tee centre of mass", model.body_ipos + 3, {0, -kCenterOfMassOffset, 0});
  expect("body pusher centre of mass", model.body_ipos + 6, {0, 0, 0});
}

struct Geom {
  std::string name;
  int type;
  int body;
  std::vector<double> pos;
  std::vector<double> size;
};

/// Geoms that can touch: the order decides the order of contacts, and with it the last bits.
void checkCollidingGeoms(const mjModel& model) {
  constexpr double kWallCentre = kWallInnerFace + kWallHalfThickness;
  const std::vector<double> wall_along_x = {kWallHalfLength, kWallHalfThickness, kWallHalfHeight};
  const std::vector<double> wall_along_y = {kWallHalfThickness, kWallHalfLength, kWallHalfHeight};
  const std::vector<Geom> geoms = {
      {"wall_y_plus", mjGEOM_BOX, 0, {0, kWallCentre, kWallHalfHeight}, wall_along_x},
      {"wall_y_minus", mjGEOM_BOX, 0, {0, -kWallCentre, kWallHalfHeight}, wall_along_x},
      {"wall_x_plus", mjGEOM_BOX, 0, {kWallCentre, 0, kWallHalfHeight}, wall_along_y},
      {"wall_x_minus", mjGEOM_BOX, 0, {-kWallCentre, 0, kWallHalfHeight}, wall_along_y},
      {"bar", mjGEOM_BOX, 1, {0, 0, 0}, {kBarHalfLength, kTeeHalfWidth, kTeeHalfWidth}},
      {"stem", mjGEOM_BOX, 1, {0, -kStemOffset, 0}, {kTeeHalfWidth, kStemHalfLength, kTeeHalfWidth}},
      {"pusher", mjGEOM_CYLINDER, 2, {0, 0, 0}, {kPusherRadius, kPusherHalfHeight}}};
  std::size_t colliding = 0;
  for (int i = 0; i < model.ngeom; ++i) {
    if (model.geom_contype[i] == 0 && model.geom_conaffinity[i] == 0) {
      continue;
    }
    if (colliding == geoms.size()) {
      const char* name = mj_id2name(&model, mjOBJ_GEOM, i);
      throw InvalidInput(std::string("geom '") + (name == nullptr ? "" : name) +
                         "' collides: only walls, bar, stem and pusher may");
    }
    const Geom& geom = geoms[colliding++];
    expectName(model, mjOBJ_GEOM, i, "colliding geom", geom.name);
    const std::string field = "geom " + geom.name + " ";
    expect(field + "contype", model.geom_contype[i], 1);
    expect(field + "conaffinity", model.geom_conaffinity[i], 1);
    expect(field + "type", model.geom_type[i], geom.type);
    expect(field + "body", model.geom_bodyid[i], geom.body);
    expect(field + "pos", model.geom_pos + 3 * i, geom.pos);
    expect(field + "quat", model.geom_quat + 4 * i, {1, 0, 0, 0});
    expect(field + "size", model.geom_size + 3 * i, geom.size);
    expect(field + "condim", model.geom_condim[i], 3);
    expect(field + "priority", model.geom_priority[i], 0);
    expect(field + "friction", model.geom_friction + 3 * i, {1, 0.005, 0.0001});
    expect(field + "solmix", model.geom_solmix[i], 1);
    expect(field + "solref", model.geom_solref + mjNREF * i, {0.02, 1});
    expect(field + "solimp", model.geom_solimp + mjNIMP * i, {0.9, 0.95, 0.001, 0.5, 2});
    expect(field + "margin", model.geom_margin[i], 0);
    expect(field + "gap", model.geom_gap[i], 0);
  }
  expect("number of colliding geoms", static_cast<double>(colliding), static_cast<double>(geoms.size()));
}

void checkActuators(const mjModel& model) {
  const std::array<std::string, 2> names = {"pusher_x", "pusher_y"};
  constexpr int kFirstPusherJoint = 3;
  for (int i = 0; i < model.nu; ++i) {
    const std::string& name = names.at(static_cast<std::size_t>(i));
    expectName(model, mjOBJ_ACTUATOR, i, "actuator", name);
    const std::string field = "actuator " + name + " ";
    expect(field + "transmission type", model.actuator_trntype[i], mjTRN_JOINT);
    expect(field + "joint", model.actuator_trnid[2 * i], kFirstPusherJoint + i);
    expect(field + "gear", model.actuator_gear[6 * i], 1);
    expect(field + "dyntype", model.actuator_dyntype[i], mjDYN_NONE);
    expect(field + "gaintype", model.actuator_gaintype[i], mjGAIN_FIXED);
    expect(field + "biastype", model.actuator_biastype[i], mjBIAS_AFFINE);
    expect(field + "gainprm", model.actuator_gainprm + mjNGAIN * i, {kServoGain, 0, 0});
    expect(field + "biasprm", model.actuator_biasprm + mjNBIAS * i, {0, 0, -kServoGain});
    expect(field + "ctrllimited", model.actuator_ctrllimited[i], 1);
    expect(field + "ctrlrange", model.actuator_ctrlrange + 2 * i, {-kActionLimit, kActionLimit});
    expect(field + "forcelimited", model.actuator_forcelimited[i], 1);
    expect(field + "forcerange", model.actuator_forcerange + 2 * i, {-kServoForce, kServoForce});
  }
}

}  // namespace

void checkScene(const mjModel& model) {
  checkSizes(model);
  checkOptions(model.opt);
  checkBodies(model);
  checkJoints(model);
  checkCollidingGeoms(model);
  checkActuators(model);
}

}  // namespace pusht
