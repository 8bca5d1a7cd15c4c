// SPDX-License-Identifier: BSD-3-Clause
// Work of the commands plan, recompute, contrast, demonstrate and audit, without their command lines.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pusht_msgs/DemonstrationStep.h>
#include <pusht_msgs/DemonstrationWorld.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <std_msgs/String.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bag/run_bag.hpp"
#include "batch/contrast.hpp"
#include "batch/demonstrate.hpp"
#include "batch/derived_files.hpp"
#include "batch/plan.hpp"
#include "batch/recompute.hpp"
#include "pusht_policy/formats.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_testing/temporary_folder.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/output_folder.hpp"
#include "sim2sim_protocol/results/provenance.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/summary.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::internal::CaptureStdout;
using ::testing::internal::GetCapturedStdout;

/// Message of the InvalidInput that `action` throws.
std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const pusht::InvalidInput& error) {
    return error.what();
  }
  return "no refusal";
}

RunConfiguration configurationOf(int episodes, double block_damp) {
  RunConfiguration configuration;
  configuration.protocol.episodes = episodes;
  configuration.protocol.floor = false;
  configuration.policy = "expert";
  configuration.reference = {"mujoco", "MuJoCo", {}, {}};
  configuration.engine = {"two_mass", "two-mass engine", {{"block_damp", block_damp}}, {}};
  return configuration;
}

/// Episodes whose reference succeeds in all, and the engine in every second. The tee diverges from that of the
/// reference by 0.2 m and 1 rad, and by `spread` more in every second episode; a tee that never moves by 0.2 m and 1
/// rad.
std::vector<EpisodeResult> episodesOf(int count, double spread) {
  std::vector<EpisodeResult> episodes;
  for (int i = 0; i < count; ++i) {
    EpisodeResult episode;
    episode.index = i;
    episode.seed = Protocol().spawnSeed(i);
    for (RolloutResult& rollout : episode.rollouts) {
      rollout.steps = 300;
      rollout.quantities.fill(0.0);
    }
    episode.rollouts[kReferenceClosed].success = true;
    episode.rollouts[kEngineClosed].success = i % 2 == 0;
    RolloutResult& replay = episode.rollouts[kEngineReplay];
    replay.at("mean_position_divergence") = 0.2 + (i % 2 == 0 ? spread : 0.0);
    replay.at("mean_angle_divergence") = 1.0 + (i % 2 == 0 ? spread : 0.0);
    replay.at("null_position_divergence") = 0.2;
    replay.at("null_angle_divergence") = 1.0;
    episodes.push_back(episode);
  }
  return episodes;
}

RunResults pilotOf(int count, double spread) {
  RunResults pilot{"pilot", nlohmann::json::object(), {}, episodesOf(count, spread)};
  pilot.protocol.episodes = count;
  return pilot;
}

/// Results of a run in a folder, as far as readResults() reads them.
fs::path writeResults(const fs::path& folder, const RunConfiguration& configuration) {
  fs::create_directories(folder);
  const std::vector<EpisodeResult> episodes = episodesOf(configuration.protocol.episodes, 0.1);
  const Summary summary = summarize(configuration.protocol, episodes);
  pusht::writeFile(folder / kMetricsFile, jsonText(metrics(configuration, summary)));
  pusht::writeFile(folder / kEpisodesFile, episodesCsv(configuration.protocol, episodes));
  return folder;
}

TEST(Plan, HasTheSmallestDifferencesInClosedForm) {
  // Differences are 0 and 0.16 in equal numbers: s = 0.08 sqrt(100 / 99). (1.960 + 0.842) s / sqrt(n) is 0.0319 for n =
  // 50 and 0.0159 for n = 200. Half of the pairs are discordant in success: 0.274 and 0.139 solve
  // d sqrt(n) = 1.960 sqrt(0.5) + 0.842 sqrt(0.5 - d^2).
  PlanQuestions questions;
  questions.episodes = {50, 200};
  EXPECT_EQ(planTable(questions, pilotOf(100, 0.16), std::nullopt),
            "smallest difference shown in [episodes]     50        200       \n"
            "success, engine - reference                 0.27      0.14      \n"
            "position divergence [m], against null model 0.032     0.016     \n"
            "angle divergence [rad], against null model  0.032     0.016     \n"
            "(found in 80 % of runs at 5 %, two-sided; spreads as in the 100 episodes of pilot)\n");
}

TEST(Plan, SaysHowManyEpisodesShowADifference) {
  // ((1.960 + 0.842) s / 0.012)^2 = 352.4 episodes.
  PlanQuestions questions;
  questions.episodes = {50};
  questions.position = 0.012;
  questions.success = 0.65;
  const std::string table = planTable(questions, pilotOf(100, 0.16), std::nullopt);
  EXPECT_THAT(table, HasSubstr("0.032     0.012: 353 episodes\n"));
  EXPECT_THAT(table, HasSubstr("0.27      0.65: none suffice: only one succeeds in 0.5 of all pairs\n"));
}

TEST(Plan, SaysWhyNoDifferenceOfSuccessIsShown) {
  RunResults pilot = pilotOf(100, 0.16);
  for (EpisodeResult& episode : pilot.episodes) {
    episode.rollouts[kEngineClosed].success = episode.rollouts[kReferenceClosed].success != (episode.index < 3);
  }
  PlanQuestions questions;
  questions.episodes = {20, 1000};
  EXPECT_THAT(planTable(questions, pilot, std::nullopt),
              HasSubstr("success, engine - reference                 none      0.015     (none: only one succeeds "
                        "in 0.03 of all pairs)\n"));
}

TEST(Plan, OfAContrastHasTheDifferencesOfTwoRuns) {
  PlanQuestions questions;
  questions.episodes = {50};
  const std::string table = planTable(questions, pilotOf(100, 0.1), pilotOf(100, 0.1));
  EXPECT_THAT(
      table,
      HasSubstr("success, other - pilot                      -         (none: only one succeeds in 0 of all pairs)\n"))
      << "no pair differs";
  EXPECT_THAT(table, HasSubstr("position divergence [m], other - pilot      0         \n"));
}

TEST(Plan, OfAPilotOfOneEpisodeSaysThatItIsTooShort) {
  PlanQuestions questions;
  questions.episodes = {50};
  questions.angle = 0.1;
  EXPECT_THAT(planTable(questions, pilotOf(1, 0.1), std::nullopt),
              HasSubstr("-         unknown: the pilot is too short\n"));
}

TEST(Plan, SaysHowManyPoliciesARankingTakes) {
  Matrix pilot{};
  pilot.simulators = {{"mujoco", "MuJoCo"}, {"chipmunk", "Chipmunk"}};
  pilot.policies.resize(10);
  for (const double tau : {0.1, 0.2, -0.5, 0.001, 1.0, std::nan("")}) {
    RankingComparison comparison{};
    comparison.kendall.value = tau;
    pilot.rankings.push_back({0, 1, 10, comparison});
  }
  EXPECT_EQ(policiesTable(pilot),
            "here    there     Kendall's tau  policies\n"
            "mujoco  chipmunk  0.1            350\n"
            "mujoco  chipmunk  0.2            89\n"
            "mujoco  chipmunk  -0.5           none suffice: the pilot's order is not preserved\n"
            "mujoco  chipmunk  0.001          more than 10000\n"
            "mujoco  chipmunk  1              8\n"
            "mujoco  chipmunk  none           none suffice: no pair of policies differs in both\n"
            "(so many policies show in 80 % of sweeps, at 5 %, that the ranking here is preserved there; tau as among "
            "the 10 policies)\n");
}

TEST(Plan, RefusesDifferencesThatAreNotAboveZero) {
  PlanOptions options;
  options.questions.angle = 0.0;
  EXPECT_EQ(refusal([&] { plan(options); }), "angle 0: must be above 0");
}

TEST(Recompute, NamesTheEpisodesThatAreMissing) {
  Protocol protocol;
  protocol.first_episode = 2;
  protocol.episodes = 8;
  const std::vector<EpisodeResult> all = episodesOf(10, 0.0);
  EXPECT_EQ(missingEpisodes(protocol, {all.begin() + 2, all.end()}), "");
  EXPECT_EQ(missingEpisodes(protocol, {}), "2 to 9");
  EXPECT_EQ(missingEpisodes(protocol, {all[2], all[4], all[7]}), "3, 5 to 6, 8 to 9");
}

TEST(Recompute, OfABagWithoutEpisodesLeavesAStatusAndNoMetrics) {
  const pusht::testing::TemporaryFolder folder;
  const RunConfiguration configuration = configurationOf(2, 6.0);
  RunBag bag(folder / "compare.bag",
             provenance(configuration, {{"runs_on", "scripted"}}, nlohmann::json::object(), nlohmann::json::object()),
             defaultWorldNames(), ros::Time(1.0));
  bag.finish();

  CaptureStdout();
  try {
    recompute({folder / "compare.bag", folder / "out"});
    ADD_FAILURE() << "the bag holds no episode";
  } catch (const pusht::RuntimeFault& fault) {
    EXPECT_THAT(fault.what(), HasSubstr("episodes 0 to 1 are missing"));
  }
  GetCapturedStdout();
  EXPECT_FALSE(fs::exists(folder / "out" / kMetricsFile));
  EXPECT_THAT(pusht::readFile(folder / "out" / kStatusFile, "status"), HasSubstr("\"exit_code\": 4"));
}

TEST(ContrastCommand, PutsTheBaselineInFront) {
  const pusht::testing::TemporaryFolder folder;
  const std::string low = writeResults(folder / "low", configurationOf(10, 2.0));
  const std::string middle = writeResults(folder / "middle", configurationOf(10, 6.0));
  const std::string high = writeResults(folder / "high", configurationOf(10, 20.0));
  std::vector<std::string> names;
  for (const RunResults& run : runsToContrast({{low, middle, high}, 2, ""})) {
    names.push_back(run.folder.filename());
  }
  EXPECT_THAT(names, ElementsAre("high", "low", "middle"));
  EXPECT_EQ(refusal([&] { runsToContrast({{low, high}, 2, ""}); }), "against 2: must be from 0 to 1");
  EXPECT_EQ(refusal([&] { runsToContrast({{low}, 0, ""}); }), "results " + low + ": is one run; name two, or a sweep");
}

TEST(ContrastCommand, WritesNoFileThatIsThere) {
  const pusht::testing::TemporaryFolder folder;
  const std::string low = writeResults(folder / "low", configurationOf(10, 2.0));
  const std::string high = writeResults(folder / "high", configurationOf(10, 20.0));
  CaptureStdout();
  contrast({{low, high}, 0, folder / "contrast.json"});
  EXPECT_THAT(GetCapturedStdout(), HasSubstr("block_damp"));
  EXPECT_TRUE(fs::exists(folder / "contrast.json"));
  EXPECT_THAT(refusal([&] { contrast({{low, high}, 0, folder / "contrast.json"}); }), HasSubstr("is there already"));
}

TEST(DerivedFiles, ReplaceNeitherOfTheTwo) {
  for (const char* name : {kAttributionTable, kAttributionFile}) {
    const pusht::testing::TemporaryFolder folder;
    pusht::writeFile(folder / name, "kept");
    EXPECT_EQ(refusal([&] { DerivedFiles("attribution", folder.path(), kAttributionFile, kAttributionTable, false); }),
              "attribution " + (folder / name).string() + ": is there already; replace it with --overwrite");
    EXPECT_EQ(pusht::readFile(folder / name, "attribution"), "kept");
  }
}

TEST(Demonstrate, WritesABagAndSaysHowManyAreSolved) {
  const pusht::testing::TemporaryFolder folder;
  DemonstrateOptions options;
  options.plan.episodes = 1;
  options.out = folder / "demonstrations.bag";
  CaptureStdout();
  demonstrate(options);
  const std::string said = GetCapturedStdout();
  EXPECT_EQ(said.find("1 demonstrations, "), 0U) << said;
  EXPECT_THAT(said, HasSubstr(" frames: " + options.out + "\n"));
  EXPECT_TRUE(fs::exists(options.out));
}

/// Demonstrations of a bag, as text.
struct Bag {
  explicit Bag(const fs::path& path) {
    rosbag::Bag bag(path.string());
    for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
      if (const auto text = message.instantiate<std_msgs::String>(); text != nullptr) {
        origin = nlohmann::json::parse(text->data);
      } else if (const auto world = message.instantiate<pusht_msgs::DemonstrationWorld>(); world != nullptr) {
        worlds.push_back(*world);
      } else if (const auto step = message.instantiate<pusht_msgs::DemonstrationStep>(); step != nullptr) {
        steps.push_back(*step);
      }
    }
  }

  nlohmann::json origin;
  std::vector<pusht_msgs::DemonstrationWorld> worlds;
  std::vector<pusht_msgs::DemonstrationStep> steps;
};

class DemonstrateAnywhere : public ::testing::Test {
 protected:
  Bag record(const std::function<void(DemonstrateOptions&)>& change) {
    DemonstrateOptions options;
    options.plan.episodes = 4;
    options.out = folder_ / ("demonstrations-" + std::to_string(++bags_) + ".bag");
    change(options);
    CaptureStdout();
    try {
      demonstrate(options);
    } catch (...) {
      GetCapturedStdout();
      throw;
    }
    GetCapturedStdout();
    return Bag(options.out);
  }

 private:
  pusht::testing::TemporaryFolder folder_;
  int bags_ = 0;
};

TEST_F(DemonstrateAnywhere, SimulatorsTakeTurns) {
  const auto simulators = [](DemonstrateOptions& options) {
    options.simulators = {"chipmunk", "two_mass:block_damp=4..8"};
  };
  const Bag bag = record(simulators);
  ASSERT_EQ(bag.worlds.size(), 4U);
  for (std::size_t i = 0; i < bag.worlds.size(); ++i) {
    EXPECT_EQ(bag.worlds[i].seed, i);
    EXPECT_EQ(bag.worlds[i].simulator, i % 2 == 0 ? "chipmunk" : "two_mass");
    EXPECT_EQ(bag.worlds[i].drawn.size(), i % 2);
  }
  EXPECT_EQ(bag.origin.at("format"), pusht::kDemonstrationFormat);
  EXPECT_EQ(bag.origin.at("simulators").at(0).at("name"), "chipmunk");
  EXPECT_EQ(bag.origin.at("simulators").at(1).at("drawn"), nlohmann::json({{"block_damp", {4.0, 8.0}}}));
  const Bag later = record([&](DemonstrateOptions& options) {
    simulators(options);
    options.plan.seed = 3;
    options.plan.episodes = 1;
  });
  EXPECT_EQ(later.worlds.front().simulator, "two_mass") << "it depends on the seed alone";
  EXPECT_EQ(later.worlds.front().drawn.front().value, bag.worlds[3].drawn.front().value);
}

TEST_F(DemonstrateAnywhere, DrawsParametersInTheirRange) {
  const Bag bag = record([](DemonstrateOptions& options) {
    options.plan.episodes = 8;
    options.settings = {"timestep=0.002..0.01", "tee_body_mass=0.4..0.6", "cone=elliptic"};
  });
  std::set<std::string> masses;
  std::set<std::string> steps;
  for (const pusht_msgs::DemonstrationWorld& world : bag.worlds) {
    ASSERT_EQ(world.drawn.size(), 2U);
    steps.insert(world.drawn[0].value);
    masses.insert(world.drawn[1].value);
    EXPECT_GE(std::stod(world.drawn[1].value), 0.4);
    EXPECT_LE(std::stod(world.drawn[1].value), 0.6);
  }
  EXPECT_EQ(masses.size(), 8U);
  EXPECT_THAT(steps, ::testing::IsSubsetOf({"0.002", "0.005", "0.01"}));
  EXPECT_GT(steps.size(), 1U);
  EXPECT_EQ(bag.origin.at("simulators").at(0).at("parameters"), nlohmann::json({{"cone", "elliptic"}}));
}

/// The bag has what the expert wanted, and worlds that took something else.
TEST_F(DemonstrateAnywhere, NoiseMovesTheWorldAndNotTheActions) {
  const auto noisy = [](double noise) {
    return [noise](DemonstrateOptions& options) {
      options.plan.episodes = 1;
      options.plan.action_noise = noise;
    };
  };
  const Bag quiet = record(noisy(0.0));
  const Bag loud = record(noisy(0.2));
  const Bag again = record(noisy(0.2));
  EXPECT_EQ(quiet.steps[0].action, loud.steps[0].action) << "the expert sees the same world";
  EXPECT_NE(quiet.steps[1].observation, loud.steps[1].observation);
  EXPECT_EQ(loud.steps[5].observation, again.steps[5].observation);
  EXPECT_EQ(loud.origin.at("action_noise"), 0.2);
}

TEST_F(DemonstrateAnywhere, RefusesWhatCannotBeDrawn) {
  const auto refused = [&](const std::vector<std::string>& simulators, const std::vector<std::string>& settings) {
    return refusal([&] {
      record([&](DemonstrateOptions& options) {
        options.simulators = simulators;
        options.settings = settings;
      });
    });
  };
  EXPECT_EQ(refused({"mujoco"}, {"tee_body_mass=0.6..0.4"}),
            "draw 'tee_body_mass=0.6..0.4': must not end below its beginning");
  EXPECT_EQ(refused({"mujoco"}, {"iterations=10..20", "iterations=5"}),
            "draw 'iterations=10..20': iterations must be given once");
  EXPECT_THAT(refused({"mujoco"}, {"solver=1..2"}), HasSubstr("solver is of type text; must be a real or an integer"));
  EXPECT_THAT(refused({"mujoco"}, {"mass=1..2"}), HasSubstr("mass"));
  EXPECT_THAT(refused({"mujoco", "chipmunk"}, {"cone=elliptic"}),
              HasSubstr("must be with its simulator, as in mujoco:cone=elliptic"));
  EXPECT_THAT(refused({"mujoco", "mujoco"}, {}), HasSubstr("must be named once each"));
  EXPECT_THAT(refused({"mujoco", "mujoco:timestep=0.01"}, {}), HasSubstr("must be named once each"));
  EXPECT_THAT(refusal([&] { record([](DemonstrateOptions& options) { options.plan.action_noise = 1.5; }); }),
              HasSubstr("action noise 1.5: must be from 0 to 1"));
}

}  // namespace
}  // namespace sim2sim
