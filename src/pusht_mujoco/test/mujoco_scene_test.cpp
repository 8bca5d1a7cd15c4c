// SPDX-License-Identifier: BSD-3-Clause
// Faults F1 to F3: scenes that do not load, are not this task, or make MuJoCo raise an error.
#include "pusht_mujoco/mujoco_scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pusht_mujoco/mujoco_guard.hpp"
#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/testing/temporary_folder.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;
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

TEST_F(Scene, TheShippedOneLoads) { EXPECT_EQ(refusal(readFile(PUSHT_SCENE, "scene")), ""); }

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
      {"timestep=\"0.01\"", "timestep=\"0.02\"", "timestep is 0.02"},
      {"timestep=\"0.01\"", "timestep=\"-1\"", "timestep is -1"},
      {"timestep=\"0.01\"", "timestep=\"nan\"", "timestep is"},
      {"timestep=\"0.01\"", "timestep=\"0.01\" collision=\"predefined\"", "option collision"},
      {"timestep=\"0.01\"", "timestep=\"0.01\" jacobian=\"sparse\"", "option jacobian"},
      {"timestep=\"0.01\"", "timestep=\"0.01\" mpr_iterations=\"1\"", "option mpr_iterations"},
      {"<worldbody>", "<include file=\"other.xml\"/><worldbody>", "must not include"},
      {"integrator=\"implicit\"", "integrator=\"RK4\"", "integrator"},
      {"damping=\"4\"", "damping=\"3\"", "joint tee_x damping is 3"},
      {"frictionloss=\"0.006\"", "frictionloss=\"0\"", "joint tee_yaw frictionloss"},
      {"axis=\"0 1 0\" damping", "axis=\"1 0 0\" damping", "joint tee_y axis"},
      {"name=\"tee_x\" type", "name=\"tea_x\" type", "'tea_x': must be 'tee_x'"},
      {"mass=\"0.06\"", "mass=\"0.07\"", "body tee centre of mass"},
      {"mass=\"0.2\"", "mass=\"0.3\"", "joint pusher_x inertia"},
      {"size=\"0.015 0.02\"", "size=\"0.016 0.02\"", "geom pusher size"},
      {"name=\"stem\" type=\"box\" pos=\"0 -0.06 0\"", "name=\"stem\" type=\"box\" pos=\"0 -0.05 0\"",
       "centre of mass"},
      {"pos=\"0 0.41 0.03\"", "pos=\"0 0.42 0.03\"", "geom wall_y_plus pos"},
      {"contype=\"0\" conaffinity=\"0\"", "", "colliding geom 4 is 'table'"},
      {"kv=\"20\"", "kv=\"21\"", "gainprm"},
      {"forcerange=\"-30 30\"", "forcerange=\"-3 3\"", "forcerange"},
      {"ctrlrange=\"-1 1\"", "", "ctrllimited"},
      {"<actuator>", "<actuator><motor name=\"more\" joint=\"tee_yaw\"/>", "number of actuators is 3"},
      {"<actuator>", "<contact><exclude body1=\"tee\" body2=\"pusher\"/></contact><actuator>", "exclusions"},
  };
  for (const Case& test : cases) {
    EXPECT_THAT(refusal(changed(test.from, test.to)), AllOf(HasSubstr("scene.xml"), HasSubstr(test.named)))
        << test.from << " -> " << test.to;
  }
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

TEST_F(Scene, F3AnErrorWhileLoadingIsARefusal) {
  EXPECT_THAT(refusal(changed("<default>", "<size nstack=\"1\"/><default>")), HasSubstr("Stack overflow"));
}

TEST(MujocoGuard, CatchesInNestedCalls) {
  EXPECT_THROW(MujocoGuard::run([] { mju_error("outer"); }), InternalError);
  MujocoGuard::run([] { mju_warning("first\nsecond"); });
  EXPECT_EQ(MujocoGuard::takeWarning(), "first second");
  EXPECT_EQ(MujocoGuard::takeWarning(), "");
}

}  // namespace
}  // namespace pusht
