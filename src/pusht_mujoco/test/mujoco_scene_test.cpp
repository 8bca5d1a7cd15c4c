// SPDX-License-Identifier: BSD-3-Clause
// Faults F1 to F3: scenes that do not load, are not this task, or make MuJoCo raise an error.
#include "pusht_mujoco/mujoco_scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "mujoco_guard.hpp"
#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/scenarios.hpp"
#include "pusht_testing/temporary_folder.hpp"
#include "scene_of_task.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Scene : public ::testing::Test {
 protected:
  void SetUp() override { fs::current_path(folder_.path()); }  // where MuJoCo would leave its log
  void TearDown() override {
    EXPECT_FALSE(fs::exists(folder_ / "MUJOCO_LOG.TXT"));
    fs::current_path(start_);
  }

  fs::path write(const std::string& xml) const {
    writeFile(folder_ / "scene.xml", xml);
    return folder_ / "scene.xml";
  }

  /// The message with which the scene is refused; empty if it is not.
  std::string refusal(const std::string& xml) const {
    try {
      MujocoScene scene(write(xml));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }

  /// The shipped scene with `from` replaced by `to`.
  static std::string changed(const std::string& from, const std::string& to) {
    std::string xml = readFile(PUSHT_SCENE, "scene");
    const std::size_t position = xml.find(from);
    EXPECT_NE(position, std::string::npos) << from;
    return xml.replace(position, from.size(), to);
  }

  testing::TemporaryFolder folder_;
  fs::path start_ = fs::current_path();
};

TEST_F(Scene, TheShippedOneLoads) {
  EXPECT_EQ(refusal(readFile(PUSHT_SCENE, "scene")), "");
  EXPECT_EQ(MujocoScene().sha256(), MujocoScene(PUSHT_SCENE).sha256()) << "with and without the file";
}

TEST_F(Scene, F1MissingEmptyTruncatedNoXml) {
  EXPECT_THROW(MujocoScene scene(folder_ / "none.xml"), InvalidInput);
  const std::string xml = readFile(PUSHT_SCENE, "scene");
  for (const std::string& bad :
       {std::string(), xml.substr(0, xml.size() / 2), std::string("no xml"), std::string("<a/>")}) {
    EXPECT_THAT(refusal(bad), AllOf(HasSubstr("scene.xml"), Not(HasSubstr("\n")))) << bad.substr(0, 20);
  }
}

TEST_F(Scene, F2EveryFieldOfTheTaskIsChecked) {
  struct Case {
    const char* from;
    const char* to;
    const char* named;
  };
  const std::vector<Case> cases = {
      {"timestep=\"0.01\"", "timestep=\"0.02\"",
       "option timestep is 0.02: must be 0.01; a scene may only look different"},
      {"timestep=\"0.01\"", "timestep=\"-1\"", "option timestep is -1.0"},
      {"timestep=\"0.01\"", "timestep=\"nan\"", "option timestep is"},
      {"timestep=\"0.01\"", "timestep=\"0.01\" collision=\"predefined\"", "option collision"},
      {"timestep=\"0.01\"", "timestep=\"0.01\" jacobian=\"sparse\"", "option jacobian"},
      {"timestep=\"0.01\"", "timestep=\"0.01\" mpr_iterations=\"1\"", "option mpr_iterations"},
      {"<worldbody>", "<include file=\"other.xml\"/><worldbody>", "must not include"},
      {"integrator=\"implicit\"", "integrator=\"RK4\"", "integrator"},
      {"damping=\"4\"", "damping=\"3\"", "joint tee_x dof_damping is 3.0: must be 4.0"},
      {"frictionloss=\"0.006\"", "frictionloss=\"0\"", "joint tee_yaw dof_frictionloss"},
      {"axis=\"0 1 0\" damping", "axis=\"1 0 0\" damping", "joint tee_y jnt_axis[0]"},
      {"name=\"tee_x\" type", "name=\"tea_x\" type", "'tea_x': must be 'tee_x'"},
      {"mass=\"0.06\"", "mass=\"0.07\"", "body tee body_mass is 0.115"},
      {"mass=\"0.2\"", "mass=\"0.3\"", "body pusher body_mass is 0.3"},
      {"size=\"0.015 0.02\"", "size=\"0.016 0.02\"", "geom pusher geom_size[0] is 0.016: must be 0.015"},
      {"name=\"stem\" type=\"box\" pos=\"0 -0.06 0\"", "name=\"stem\" type=\"box\" pos=\"0 -0.05 0\"",
       "geom stem geom_pos[1] is -0.05"},
      {"pos=\"0 0.41 0.03\"", "pos=\"0 0.42 0.03\"", "geom wall_y_plus geom_pos[1]"},
      {"contype=\"0\" conaffinity=\"0\"", "", "colliding geom 4 is 'table'"},
      {"kv=\"20\"", "kv=\"21\"", "actuator pusher_x actuator_gainprm[0]"},
      {"forcerange=\"-30 30\"", "forcerange=\"-3 3\"", "actuator pusher_x actuator_forcerange[0]"},
      {"ctrlrange=\"-1 1\"", "", "actuator_ctrllimited"},
      {"<actuator>", "<actuator><motor name=\"more\" joint=\"tee_yaw\"/>", "actuator 0 is 'more': must be 'pusher_x'"},
      {"<worldbody>", "<statistic meaninertia=\"5\"/><worldbody>", "statistic meaninertia is 5.0"},
      {"<geom name=\"bar\"",
       "<geom type=\"sphere\" size=\"0.001\" mass=\"1e-12\" contype=\"0\" conaffinity=\"0\"/><geom name=\"bar\"",
       "body tee body_mass is 0.105"},
      {"<actuator>", "<contact><exclude body1=\"tee\" body2=\"pusher\"/></contact><actuator>",
       "nexclude is 1: must be 0"},
  };
  for (const Case& test : cases) {
    EXPECT_THAT(refusal(changed(test.from, test.to)), AllOf(HasSubstr("scene.xml"), HasSubstr(test.named)))
        << test.from << " -> " << test.to;
  }
}

/// The check holds other scenes against the shipped one; this holds the shipped one against the task.
TEST_F(Scene, TheShippedOneIsTheTask) {
  const MujocoScene scene(PUSHT_SCENE);
  const mjModel& model = scene.model();
  const auto geom = [&](const char* name) { return mj_name2id(&model, mjOBJ_GEOM, name); };
  EXPECT_EQ(model.opt.timestep, kSubstep);
  EXPECT_DOUBLE_EQ(model.body_mass[1], kBarMass + kStemMass);
  EXPECT_DOUBLE_EQ(model.body_ipos[4], -kCenterOfMassOffset);
  EXPECT_EQ(model.geom_size[3 * geom("bar")], kBarHalfLength);
  EXPECT_EQ(model.geom_size[3 * geom("bar") + 1], kTeeHalfWidth);
  EXPECT_EQ(model.geom_size[3 * geom("stem")], kTeeHalfWidth);
  EXPECT_EQ(model.geom_size[3 * geom("stem") + 1], kStemHalfLength);
  EXPECT_EQ(model.geom_pos[3 * geom("stem") + 1], -kStemOffset);
  EXPECT_EQ(model.geom_size[3 * geom("pusher")], kPusherRadius);
  EXPECT_DOUBLE_EQ(model.geom_pos[3 * geom("wall_y_plus") + 1] - model.geom_size[3 * geom("wall_y_plus") + 1],
                   kWallInnerFace);
  EXPECT_EQ(model.actuator_ctrlrange[1], kActionLimit);
}

TEST_F(Scene, TheShippedOneHasTheDynamicsThatOtherEnginesFollow) {
  const MujocoScene scene;
  const mjModel& model = scene.model();
  const auto dof = [&](const char* joint) { return model.jnt_dofadr[mj_name2id(&model, mjOBJ_JOINT, joint)]; };
  const auto geom = [&](const char* name) { return mj_name2id(&model, mjOBJ_GEOM, name); };
  EXPECT_EQ(model.body_mass[mj_name2id(&model, mjOBJ_BODY, "pusher")], dynamics::kPusherMass);
  EXPECT_EQ(model.actuator_gainprm[0], dynamics::kServoGain);
  EXPECT_EQ(model.actuator_biasprm[2], -dynamics::kServoGain);
  EXPECT_EQ(model.actuator_forcerange[1], dynamics::kServoLimit);
  EXPECT_EQ(model.dof_damping[dof("pusher_x")], dynamics::kPusherDamping);
  EXPECT_EQ(model.dof_damping[dof("tee_y")], dynamics::kTeeDamping);
  EXPECT_EQ(model.dof_damping[dof("tee_yaw")], dynamics::kTeeYawDamping);
  EXPECT_EQ(model.dof_frictionloss[dof("tee_x")], dynamics::kTeeFriction);
  EXPECT_EQ(model.dof_frictionloss[dof("tee_yaw")], dynamics::kTeeYawFriction);
  EXPECT_EQ(model.geom_friction[3 * geom("pusher")], dynamics::kContactFriction);
  EXPECT_EQ(2.0 * model.geom_size[3 * geom("wall_y_plus") + 1], dynamics::kWallThickness);
}

/// All positions and velocities of a pusher that chases the tee.
std::vector<double> chase(const std::shared_ptr<const MujocoScene>& scene) {
  MujocoWorld world(scene);
  std::vector<double> trajectory;
  for (const std::uint64_t seed : {0U, 1U}) {
    world.reset(spawn(seed));
    for (int step = 0; step < 60; ++step) {
      world.step(testing::chase(world.state()));
      const WorldState state = world.state();
      for (const Eigen::Vector2d& v :
           {state.pusher_position, state.pusher_velocity, state.tee_position, state.tee_velocity}) {
        trajectory.insert(trajectory.end(), {v.x(), v.y()});
      }
      trajectory.insert(trajectory.end(), {state.tee_yaw, state.tee_yaw_rate});
    }
  }
  return trajectory;
}

/// The scene with each number of each attribute changed in turn, a little and much.
std::vector<std::string> withOneNumberChanged(const std::string& xml) {
  const std::regex attribute("([a-z]+)=\"(-?[0-9][^\"]*)\"");
  const std::regex number("[-0-9.]+");
  std::vector<std::string> changed;
  const std::size_t body = xml.find("<mujoco");  // after the comment
  for (std::sregex_iterator a(xml.begin() + static_cast<std::ptrdiff_t>(body), xml.end(), attribute), end; a != end;
       ++a) {
    const std::string values = a->str(2);
    for (std::sregex_iterator n(values.begin(), values.end(), number); n != end; ++n) {
      for (const double change : {1e-12, 0.1}) {
        const std::string text = shortestText(std::stod(n->str()) + change);
        const std::size_t place = body + static_cast<std::size_t>(a->position(2) + n->position());
        changed.push_back(std::string(xml).replace(place, static_cast<std::size_t>(n->length()), text));
      }
    }
  }
  return changed;
}

/// Pieces that MJCF allows, each put behind a tag of the scene.
std::vector<std::string> withOnePieceMore(const std::string& xml) {
  const std::string bar = R"(<joint name="tee_yaw" type="hinge" axis="0 0 1" damping="0.02" frictionloss="0.006"/>)";
  const std::vector<std::pair<std::string, std::string>> pieces = {
      {"<mujoco model=\"pusht\">", "<statistic meaninertia=\"5\"/>"},
      {"<mujoco model=\"pusht\">", "<statistic extent=\"5\" meansize=\"2\"/>"},
      {"<mujoco model=\"pusht\">", "<size njmax=\"500\" nconmax=\"100\"/>"},
      {"<mujoco model=\"pusht\">", "<size nuserdata=\"3\"/>"},
      {"<mujoco model=\"pusht\">", "<visual><map znear=\"0.1\"/></visual>"},
      {"<mujoco model=\"pusht\">", "<option><flag warmstart=\"disable\"/></option>"},
      {"<mujoco model=\"pusht\">", "<option><flag refsafe=\"disable\"/></option>"},
      {"<mujoco model=\"pusht\">", "<compiler inertiafromgeom=\"true\" balanceinertia=\"true\"/>"},
      {"<mujoco model=\"pusht\">", "<compiler boundmass=\"0.11\"/>"},
      {"<mujoco model=\"pusht\">", "<compiler settotalmass=\"0.305\"/>"},
      {"<mujoco model=\"pusht\">", "<default><joint armature=\"1e-15\"/></default>"},
      {"<mujoco model=\"pusht\">", "<default><joint stiffness=\"1e-15\" springref=\"1\"/></default>"},
      {"<mujoco model=\"pusht\">", "<default><joint solreffriction=\"0.03 1\"/></default>"},
      {"<mujoco model=\"pusht\">", "<default><geom friction=\"0.9 0.005 0.0001\"/></default>"},
      {"<mujoco model=\"pusht\">", "<default><geom solimp=\"0.9 0.95 0.002\"/></default>"},
      {"<mujoco model=\"pusht\">", "<default><geom fluidshape=\"ellipsoid\"/></default>"},
      {"<mujoco model=\"pusht\">", "<default><geom group=\"3\"/></default>"},
      {bar, "<geom type=\"sphere\" size=\"0.001\" mass=\"1e-12\" contype=\"0\" conaffinity=\"0\"/>"},
      {bar, "<geom type=\"sphere\" size=\"0.001\" mass=\"0\" contype=\"0\" conaffinity=\"0\"/>"},
      {bar, "<geom type=\"sphere\" size=\"0.001\" contype=\"0\" conaffinity=\"0\"/>"},
      {bar, "<geom type=\"sphere\" size=\"0.001\" mass=\"1e-12\"/>"},
      {bar, "<site name=\"grip\" pos=\"0 0.1 0\"/>"},
      {bar, "<light pos=\"0 0 1\"/><camera pos=\"0 0 1\"/>"},
      {bar, "<body><geom type=\"sphere\" size=\"0.001\" mass=\"1e-12\"/></body>"},
      {"<worldbody>", "<geom type=\"box\" size=\"1 1 1\" contype=\"0\" conaffinity=\"0\"/>"},
      {"<worldbody>", "<geom type=\"plane\" size=\"1 1 1\"/>"},
      {"<worldbody>", "<body name=\"ghost\" mocap=\"true\"/>"},
      {"</worldbody>", "<keyframe><key qpos=\"1 0 0 0 0\"/></keyframe>"},
      {"</worldbody>", "<sensor><jointpos joint=\"tee_x\"/></sensor>"},
      {"</worldbody>", "<contact><pair geom1=\"bar\" geom2=\"pusher\"/></contact>"},
      {"</worldbody>", "<equality><joint joint1=\"tee_x\" joint2=\"tee_y\"/></equality>"},
      {"</worldbody>", "<custom><numeric name=\"n\" data=\"3\"/></custom>"},
      {"</worldbody>", "<asset><material name=\"m\" rgba=\"1 0 0 1\"/></asset>"},
  };
  std::vector<std::string> changed;
  for (const auto& [tag, piece] : pieces) {
    const std::size_t place = xml.find(tag);
    EXPECT_NE(place, std::string::npos) << tag;
    changed.push_back(std::string(xml).insert(place + tag.size(), piece));
  }
  return changed;
}

TEST_F(Scene, WhateverChangesIsRefusedByNameOrChangesNoBit) {
  const std::string xml = readFile(PUSHT_SCENE, "scene");
  const std::vector<double> expected = chase(std::make_shared<const MujocoScene>(PUSHT_SCENE));
  std::vector<std::string> changed = withOneNumberChanged(xml);
  const std::vector<std::string> more = withOnePieceMore(xml);
  changed.insert(changed.end(), more.begin(), more.end());
  int refused = 0;
  int accepted = 0;
  for (const std::string& scene : changed) {
    const auto difference = std::mismatch(scene.begin(), scene.end(), xml.begin(), xml.end());
    const std::string at(
        std::max(scene.begin(), difference.first - std::min<std::ptrdiff_t>(40, difference.first - scene.begin())),
        difference.first + std::min<std::ptrdiff_t>(60, scene.end() - difference.first));
    const std::string why = refusal(scene);
    if (why.empty()) {
      EXPECT_TRUE(chase(std::make_shared<const MujocoScene>(folder_ / "scene.xml")) == expected) << at;
      ++accepted;
    } else {
      EXPECT_THAT(why, HasSubstr("scene.xml: ")) << at;
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(accepted, 50) << "what only looks different is free";
}

TEST_F(Scene, F3AnErrorOfMujocoIsAnExceptionNotAPrompt) {
  const auto scene = std::make_shared<MujocoScene>(PUSHT_SCENE);
  MujocoWorld world(scene);
  world.reset(spawn(0));
  const_cast<mjModel&>(scene->model()).opt.integrator = 17;  // no scene that passes the check makes mj_step fail
  try {
    world.step({0.0F, 0.0F});
    FAIL() << "MuJoCo must have raised an error";
  } catch (const InternalError& error) {
    EXPECT_THAT(error.what(), HasSubstr("integrator"));
  }
  MujocoWorld sound(std::make_shared<const MujocoScene>(PUSHT_SCENE));
  sound.reset(spawn(0));
  sound.step({0.0F, 0.0F});
}

/// MuJoCo counts a warning once, sets its world to its first state and goes on from there.
TEST_F(Scene, F21AWarningOfMujocoIsAFault) {
  const auto scene = std::make_shared<MujocoScene>(PUSHT_SCENE);
  MujocoWorld world(scene);
  world.reset(spawn(0));
  const_cast<mjModel&>(scene->model()).opt.gravity[0] = 1e30;
  try {
    world.step({0.0F, 0.0F});
    FAIL() << "MuJoCo must have warned";
  } catch (const SimulationFault& fault) {
    EXPECT_THAT(fault.what(), HasSubstr("MuJoCo: Nan, Inf or huge value in QACC"));
  }
}

TEST_F(Scene, F3AnErrorWhileLoadingIsARefusal) {
  EXPECT_THAT(refusal(changed("<default>", "<size nstack=\"1\"/><default>")), HasSubstr("Stack overflow"));
}

TEST(MujocoGuard, CatchesInNestedCalls) {
  EXPECT_THROW(MujocoGuard::run([] { mju_error("outer"); }), InternalError);
  MujocoGuard::run([] { mju_warning("first\nsecond"); });
  EXPECT_EQ(MujocoGuard::takeWarning(), "first second");
  EXPECT_EQ(MujocoGuard::takeWarning(), "");
}

/// The scene that is made of full_circle's numbers is the one that ships, to the last bit of every field; but for where
/// the walls' middles are, which are a sum.
TEST_F(Scene, MadeOfTheCoursesNumbersIsTheShippedOne) {
  const std::string made = std::regex_replace(sceneOf(fullCircle()), std::regex("0\\.41000000000000003"), "0.41");
  EXPECT_EQ(refusal(made), "");
  EXPECT_NE(MujocoScene(write(made)).sha256(), MujocoScene().sha256()) << "by other words";
}

TEST_F(Scene, OfAnotherTaskIsRefused) {
  const std::string xml = sceneOf(gymPusht());
  EXPECT_EQ(MujocoScene(write(xml), gymPusht()).sha256(), MujocoScene(gymPusht()).sha256());
  EXPECT_THAT(refusal(xml), HasSubstr("a scene may only look different"));
  EXPECT_THAT(testing::refusalOf([&] { MujocoScene scene(PUSHT_SCENE, gymPusht()); }),
              HasSubstr("a scene may only look different"));
}

/// MuJoCo's own numbers of gym-pusht's tee: mass, moment about the center of mass, where the body's origin is.
TEST_F(Scene, OfGymPushtHasItsNumbers) {
  const MujocoScene scene(gymPusht());
  const Physics& physics = gymPusht().physics;
  const int tee = mj_name2id(&scene.model(), mjOBJ_BODY, "tee");
  EXPECT_DOUBLE_EQ(scene.model().body_mass[tee], 1.0);
  EXPECT_NEAR(scene.model().body_ipos[3 * tee + 1], 0.0, 1e-15) << "the table acts at the center of mass";
  const mjtNum* const moments = scene.model().body_inertia + 3 * tee;  // of the principal axes; z has the largest
  EXPECT_NEAR(*std::max_element(moments, moments + 3),
              physics.tee_second_moment - physics.centerOfMass() * physics.centerOfMass(), 1e-15);
  EXPECT_EQ(scene.model().actuator_gainprm[0], physics.servo_stiffness);
}

TEST_F(Scene, OfATeeThatIsNoTwoBoxesIsRefused) {
  const std::string file = R"({"name": "odd", "physics": {"tee_second_moment": 0.001}})";
  const Task& task = taskNamed(file);
  EXPECT_THAT(testing::refusalOf([&] { sceneOf(task); }),
              AllOf(HasSubstr("task odd: physics.tee_second_moment 0.001 must be "), HasSubstr("in mujoco")));
}

/// A drive to a position with damping alone is a harmonic oscillator of which the closed form is known: from rest,
/// critically damped for these numbers, x(t) = way * (1 - (1 + 10 t) exp(-10 t)) for a stiffness of 100/s^2 and a
/// damping of 20/s. MuJoCo's substeps are of first order.
TEST_F(Scene, OfGymPushtDrivesThePusherToAPosition) {
  MujocoWorld world(std::make_shared<const MujocoScene>(gymPusht()), gymPusht());
  WorldState start;
  start.tee_position = {0.15, 0.15};
  start.pusher_position = {-0.1, -0.1};
  world.reset(start);
  EXPECT_EQ(world.state(), start);
  const Vector2d target(0.0, -0.1);
  const Vector2d command = gymPusht().frame.pointFromTable(target);
  for (int step = 1; step <= 5; ++step) {
    world.step({static_cast<float>(command.x()), static_cast<float>(command.y())});
    const double t = kControlStep * step;
    EXPECT_NEAR(world.state().pusher_position.x(), -0.1 + 0.1 * (1.0 - (1.0 + 10.0 * t) * std::exp(-10.0 * t)), 3e-3);
    EXPECT_NEAR(world.state().pusher_position.y(), -0.1, 1e-6);
  }
}

}  // namespace
}  // namespace pusht
