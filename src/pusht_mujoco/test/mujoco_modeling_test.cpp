// SPDX-License-Identifier: BSD-3-Clause
// Parameters of MuJoCo's modeling, held against a plain program over the MuJoCo library.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "pusht_mujoco/mujoco_kind.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/scenarios.hpp"
#include "pusht_testing/temporary_folder.hpp"

namespace pusht {
namespace {

using ::testing::HasSubstr;
using testing::refusalOf;

using Settings = std::vector<std::pair<std::string, std::string>>;  // parameter and value
using Edits = std::vector<std::pair<std::string, std::string>>;     // pattern in the shipped MJCF, and what replaces it
using Positions = std::vector<std::array<double, 5>>;               // tee x, y, yaw; pusher x, y; by control step

constexpr int kSteps = 60;

/// Pushes to and fro along the way to the tee.
std::vector<Action> actionsFrom(const WorldState& start) {
  const Eigen::Vector2d way = (start.tee_position - start.pusher_position).normalized();
  std::vector<Action> actions;
  for (int step = 0; step < kSteps; ++step) {
    const double speed = step % 20 < 15 ? 0.5 : -0.4;
    actions.push_back({static_cast<float>(speed * way.x()), static_cast<float>(speed * way.y() + 0.05)});
  }
  return actions;
}

/// The plain program: loads an edited copy of the shipped scene, and steps it with MuJoCo's own calls.
Positions plainly(const WorldState& start, const Edits& edits, int substeps) {
  std::string xml = readFile(PUSHT_SCENE, "scene");
  for (const auto& [pattern, text] : edits) {
    EXPECT_TRUE(std::regex_search(xml, std::regex(pattern))) << pattern;
    xml = std::regex_replace(xml, std::regex(pattern), text);
  }
  const testing::TemporaryFolder folder;
  writeFile(folder / "scene.xml", xml);
  std::array<char, 1000> message{};
  mjModel* const model = mj_loadXML((folder / "scene.xml").c_str(), nullptr, message.data(), message.size());
  EXPECT_NE(model, nullptr) << message.data();
  mjData* const data = mj_makeData(model);
  const std::array<double, 5> pose = {start.tee_position.x(), start.tee_position.y(), start.tee_yaw,
                                      start.pusher_position.x(), start.pusher_position.y()};
  std::copy(pose.begin(), pose.end(), data->qpos);
  mj_forward(model, data);
  Positions positions;
  for (const Action& action : actionsFrom(start)) {
    data->ctrl[0] = action[0];
    data->ctrl[1] = action[1];
    for (int i = 0; i < substeps; ++i) {
      mj_step(model, data);
    }
    positions.push_back({data->qpos[0], data->qpos[1], wrapAngle(data->qpos[2]), data->qpos[3], data->qpos[4]});
  }
  mj_deleteData(data);
  mj_deleteModel(model);
  return positions;
}

Positions byTheKind(const WorldState& start, const Settings& settings) {
  ParameterSet parameters = mujocoKind().defaults();
  for (const auto& [name, text] : settings) {
    parameters.set(name, text);
  }
  const std::unique_ptr<Simulator> world = mujocoKind().load(parameters).make_world();
  world->reset(start);
  Positions positions;
  for (const Action& action : actionsFrom(start)) {
    world->step(action);
    const WorldState state = world->state();
    positions.push_back({state.tee_position.x(), state.tee_position.y(), state.tee_yaw, state.pusher_position.x(),
                         state.pusher_position.y()});
  }
  return positions;
}

double largestDifference(const Positions& a, const Positions& b) {
  double largest = 0.0;
  for (std::size_t step = 0; step < a.size(); ++step) {
    for (std::size_t i = 0; i < a[step].size(); ++i) {
      largest = std::max(largest, std::abs(a[step][i] - b[step][i]));
    }
  }
  return largest;
}

struct Variant {
  Settings settings;
  Edits edits;
  int substeps = 10;
  double tolerance = 0.0;  ///< [m, rad]; 0: bit for bit
};

std::vector<Variant> variants() {
  const std::string options = R"(timestep="0.01" integrator="implicit")";
  const auto option = [&](const std::string& text) { return Edits{{options, options + " " + text}}; };
  const auto contact = [](const std::string& text) {
    return Edits{{"<default>\n", "<default>\n<geom " + text + "/>\n"}};
  };
  return {
      {{}, {}},
      {{{"timestep", "0.005"}}, {{"timestep=\"0.01\"", "timestep=\"0.005\""}}, 20},
      {{{"timestep", "0.002"}}, {{"timestep=\"0.01\"", "timestep=\"0.002\""}}, 50},
      {{{"timestep", "0.001"}}, {{"timestep=\"0.01\"", "timestep=\"0.001\""}}, 100},
      {{{"timestep", "0.0005"}}, {{"timestep=\"0.01\"", "timestep=\"0.0005\""}}, 200},
      {{{"integrator", "Euler"}}, {{"integrator=\"implicit\"", "integrator=\"Euler\""}}},
      {{{"integrator", "RK4"}}, {{"integrator=\"implicit\"", "integrator=\"RK4\""}}},
      {{{"cone", "elliptic"}}, option("cone=\"elliptic\"")},
      {{{"cone", "elliptic"}, {"impratio", "10.0"}}, option("cone=\"elliptic\" impratio=\"10\"")},
      {{{"solver", "CG"}}, option("solver=\"CG\"")},
      {{{"solver", "PGS"}}, option("solver=\"PGS\"")},
      {{{"iterations", "2"}, {"solver", "PGS"}}, option("iterations=\"2\" solver=\"PGS\"")},
      {{{"contact_friction", "0.5"}}, contact("friction=\"0.5\"")},
      {{{"contact_time", "0.05"}, {"contact_damping", "0.7"}}, contact("solref=\"0.05 0.7\"")},
      {{{"contact_impedance", "0.8"}, {"contact_most_impedance", "0.9"}, {"contact_width", "0.002"}},
       contact("solimp=\"0.8 0.9 0.002\"")},
      {{{"tee_damping", "2.0"}}, {{"damping=\"4\"", "damping=\"2\""}}},
      {{{"tee_yaw_damping", "0.04"}}, {{"damping=\"0.02\"", "damping=\"0.04\""}}},
      {{{"tee_friction", "0.6"}}, {{"frictionloss=\"1.2\"", "frictionloss=\"0.6\""}}},
      {{{"tee_yaw_friction", "0.012"}}, {{"frictionloss=\"0.006\"", "frictionloss=\"0.012\""}}},
      {{{"pusher_damping", "1.5"}}, {{"damping=\"0.5\"", "damping=\"1.5\""}}},
      {{{"servo_gain", "12.0"}}, {{"kv=\"20\"", "kv=\"12\""}}},
      {{{"servo_limit", "2.0"}}, {{"forcerange=\"-30 30\"", "forcerange=\"-2 2\""}}},
      // The compiler sums moments of inertia of boxes, which are scaled here: the last bits differ.
      {{{"tee_body_mass", "0.21"}},
       {{"mass=\"0.06\"", "mass=\"0.12\""}, {"mass=\"0.045\"", "mass=\"0.09\""}},
       10,
       1e-9},
      {{{"pusher_body_mass", "0.4"}}, {{"mass=\"0.2\"", "mass=\"0.4\""}}, 10, 1e-9},
  };
}

std::string textOf(const Settings& settings) {
  std::string text;
  for (const auto& [name, value] : settings) {
    text.append(name).append("=").append(value).append(" ");
  }
  return text;
}

TEST(MujocoModeling, IsThatOfAPlainProgram) {
  for (const Variant& variant : variants()) {
    for (const std::uint64_t seed : {3, 11}) {
      const WorldState start = spawn(seed);
      const Positions found = byTheKind(start, variant.settings);
      EXPECT_LE(largestDifference(found, plainly(start, variant.edits, variant.substeps)), variant.tolerance)
          << textOf(variant.settings) << "seed " << seed;
    }
  }
}

TEST(MujocoModeling, EveryParameterChangesATrajectory) {
  for (const Variant& variant : variants()) {
    double change = 0.0;
    for (const std::uint64_t seed : {3, 11}) {
      const WorldState start = spawn(seed);
      change = std::max(change, largestDifference(byTheKind(start, {}), byTheKind(start, variant.settings)));
    }
    EXPECT_EQ(change > 0.0, !variant.settings.empty()) << textOf(variant.settings);
  }
}

TEST(MujocoModeling, RefusesWhatItCannotRun) {
  const auto refusal = [](const std::string& name, const std::string& text) {
    return refusalOf([&] { mujocoKind().defaults().set(name, text); });
  };
  EXPECT_EQ(refusal("timestep", "0.003"),
            "timestep 0.003: must be one of: 0.01, 0.005, 0.002, 0.001, 0.0005 [s]: 0.01 divided by 1, 2, 5, 10 or 20");
  EXPECT_THAT(refusal("timestep", "nan"), HasSubstr("timestep"));
  EXPECT_EQ(refusal("integrator", "implicitfast"), "integrator 'implicitfast': must be one of: Euler, RK4, implicit");
  EXPECT_THAT(refusal("tee_body_mass", "0.0"), HasSubstr("tee_body_mass 0.0: must be from 0.001"));
  EXPECT_THAT(refusal("iterations", "0"), HasSubstr("iterations 0: must be from 1 to"));
}

}  // namespace
}  // namespace pusht
