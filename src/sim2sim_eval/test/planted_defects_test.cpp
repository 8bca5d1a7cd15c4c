// SPDX-License-Identifier: BSD-3-Clause
// Whether attribution tells the truth: defects are planted in a copy of the faithful engine, and in a switch of
// Chipmunk, and it must find them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "chipmunk_scene.hpp"
#include "pusht_engine/rigid_body_engine.hpp"
#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_task/task.hpp"
#include "pusht_testing/golden.hpp"
#include "sim2sim_statistics/shapley.hpp"

namespace sim2sim {
namespace {

using pusht::rigid_body::Model;

struct Defect {
  const char* name;
  void (*plant)(Model& model);
};

const std::array<Defect, 5> kDefects = {{
    {"tee moment", [](Model& model) { model.tee_moment *= 1.5; }},
    {"pusher mass", [](Model& model) { model.pusher_mass *= 2.0; }},
    {"servo gain", [](Model& model) { model.servo_gain *= 0.7; }},
    {"tee damping", [](Model& model) { model.tee_damping *= 0.5; }},
    {"table friction",
     [](Model& model) {
       model.coulomb_limit = {0.0, 0.0, 0.0};
     }},
}};
constexpr int kPlayers = static_cast<int>(kDefects.size());

/// A copy of the faithful engine in which some defects are planted, and some repaired.
struct PlantedPhysics : pusht::RigidBodyPhysics {
  struct Parameters {
    Coalition planted = 0;
    Coalition repaired = 0;
  };

  static Model modelOf(const Parameters& parameters) {
    Model model = pusht::rigid_body::modelOf({});
    for (std::size_t i = 0; i < kDefects.size(); ++i) {
      if (((parameters.planted & ~parameters.repaired) >> i & 1U) != 0) {
        kDefects[i].plant(model);
      }
    }
    return model;
  }
};
using PlantedEngine = pusht::PlanarSimulator<PlantedPhysics>;

struct Recorded {
  std::vector<pusht::WorldState> states;  ///< of MuJoCo
  std::vector<pusht::Action> actions;
};

/// The first episodes of the golden file in MuJoCo; as many as an interval needs.
const std::vector<Recorded>& episodes() {
  static const std::vector<Recorded> recorded = [] {
    pusht::MujocoWorld reference(std::make_shared<const pusht::MujocoScene>());
    std::vector<Recorded> result;
    for (const auto& golden : pusht::testing::loadGolden("expert_actions.json", "cases")) {
      reference.reset(pusht::testing::worldPose(golden.at("start_tee_xyyaw_pusher_xy")));
      Recorded episode = {{reference.state()}, {}};
      for (const auto& action : golden.at("actions")) {
        episode.actions.push_back(pusht::testing::action(action));
        reference.step(episode.actions.back());
        episode.states.push_back(reference.state());
      }
      result.push_back(episode);
      if (result.size() == kFewestPairs) {
        break;
      }
    }
    return result;
  }();
  return recorded;
}

/// [m] Mean distance of the tees over an episode in which the engine gets MuJoCo's state every 20 steps.
double gapOf(const Recorded& episode, pusht::Simulator& engine) {
  constexpr std::size_t kAnchor = 20;
  double sum = 0.0;
  for (std::size_t step = 0; step < episode.actions.size(); ++step) {
    if (step % kAnchor == 0) {
      engine.reset(episode.states[step]);
    }
    engine.step(episode.actions[step]);
    sum += (engine.state().tee_position - episode.states[step + 1].tee_position).norm();
  }
  return sum / static_cast<double>(episode.actions.size());
}

/// Gaps by coalition, each one run.
template <class MakeWorld>
Game gameOf(int players, const MakeWorld& make_world) {
  std::vector<std::vector<double>> gaps(std::size_t{1} << players);
  for (Coalition on = 0; on < gaps.size(); ++on) {
    const std::unique_ptr<pusht::Simulator> world = make_world(on);
    for (const Recorded& episode : episodes()) {
      gaps[on].push_back(gapOf(episode, *world));
    }
  }
  return Game(players, gaps);
}

/// Repairs are the players, also those of what is whole.
Game gameOf(Coalition planted) {
  return gameOf(kPlayers, [planted](Coalition repaired) {
    return std::make_unique<PlantedEngine>(PlantedPhysics::Parameters{planted, repaired});
  });
}

/// The switches of Chipmunk's mapping are the players. Where the servo is the task's, its gain is so many times the
/// task's.
Game gameOfChipmunk(double gain) {
  constexpr int kSwitches = static_cast<int>(pusht::ChipmunkScene::kSwitches.size());
  return gameOf(kSwitches, [gain](Coalition on) {
    pusht::ChipmunkParameters parameters;
    for (std::size_t i = 0; i < kSwitches; ++i) {
      parameters.*pusht::ChipmunkScene::kSwitches[i].value = (on >> i & 1U) != 0;
    }
    pusht::Physics physics;
    physics.servo_gain *= parameters.servo ? gain : 1.0;
    return pusht::worldOf<pusht::ChipmunkScene>(parameters, physics);
  });
}

/// [m] The faithful engine's own gap to MuJoCo is less than that.
constexpr double kFloor = 2e-5;

Coalition only(std::size_t defect) { return Coalition{1} << defect; }

class OneDefect : public ::testing::TestWithParam<std::size_t> {};

TEST_P(OneDefect, HasAllOfTheGap) {
  const Game game = gameOf(only(GetParam()));
  ASSERT_GT(game.meanGap(0), 5.0 * kFloor) << kDefects[GetParam()].name << ": the defect must be felt";
  EXPECT_LT(game.meanGap(game.all()), kFloor);
  const std::vector<Share> found = shares(game);
  for (std::size_t i = 0; i < kDefects.size(); ++i) {
    EXPECT_NEAR(found[i].part, i == GetParam() ? 1.0 : 0.0, 1e-9) << kDefects[i].name;
  }
}

INSTANTIATE_TEST_SUITE_P(EachAlone, OneDefect, ::testing::Range(std::size_t{0}, kDefects.size()));

/// Both are found, and nothing else is.
TEST(TwoDefects, ShareTheGap) {
  constexpr std::size_t kServo = 2;
  constexpr std::size_t kFriction = 4;
  const Game game = gameOf(only(kServo) | only(kFriction));
  const std::vector<Share> found = shares(game);
  double sum = 0.0;
  for (std::size_t i = 0; i < kDefects.size(); ++i) {
    sum += found[i].value;
    if (i == kServo || i == kFriction) {
      ASSERT_TRUE(found[i].interval) << kDefects[i].name;
      EXPECT_GT(found[i].interval->low, 0.0) << kDefects[i].name;
    } else {
      EXPECT_EQ(found[i].value, 0.0) << kDefects[i].name;
    }
  }
  EXPECT_NEAR(sum, game.meanGap(0) - game.meanGap(game.all()), 1e-15);
}

/// Its share falls, beyond its interval, and by more than that of any other switch.
TEST(DefectInASwitch, IsFound) {
  const Game sound = gameOfChipmunk(1.0);
  const Game defective = gameOfChipmunk(0.25);
  const std::vector<Share> before = shares(sound);
  const std::vector<Share> after = shares(defective);
  std::vector<double> changes;
  double sum = 0.0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    changes.push_back(std::abs(after[i].value - before[i].value));
    sum += after[i].value;
  }
  const auto most = static_cast<std::size_t>(std::max_element(changes.begin(), changes.end()) - changes.begin());
  EXPECT_STREQ(pusht::ChipmunkScene::kSwitches[most].name, "servo");
  EXPECT_LT(after[most].interval->high, before[most].interval->low);
  EXPECT_NEAR(sum, defective.meanGap(0) - defective.meanGap(defective.all()), 1e-12);
}

TEST(NoDefect, NothingIsFound) {
  const Game game = gameOf(0);
  EXPECT_LT(game.meanGap(0), kFloor);
  for (const Share& share : shares(game)) {
    EXPECT_EQ(share.value, 0.0);
    EXPECT_FALSE(share.interval);
    EXPECT_TRUE(std::isnan(share.part));
  }
}

}  // namespace
}  // namespace sim2sim
