// SPDX-License-Identifier: BSD-3-Clause
/// Every option of a run takes every way there and back.
#include "sim2sim_protocol/run_options.hpp"

#include <gmock/gmock.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batch/sweep_plan.hpp"
#include "live/named_options.hpp"
#include "live/request.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/temporary_folder.hpp"
#include "sim2sim_eval/batch/batch_options.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {
namespace {

void change(int& value) {
  value = value == 0 ? 7 : value == 1 ? 5 : value - 1;
}  // the usual 50 episodes are 10 times 5
void change(std::uint64_t& value) { value = (std::uint64_t{1} << 63U) + 1U; }  // which no double holds
void change(double& value) { value = value == 0.0 ? 0.01 : 3.0 * value; }
void change(bool& value) { value = !value; }
void change(std::string& value) { value = "gym_pusht"; }
void change(std::vector<int>& value) { value = {2, 40}; }
void change(std::optional<double>& value) { value = 0.75; }
void change(std::vector<std::string>& value) { value = {"timestep=0.005", "cone=elliptic:impratio=10.0"}; }

/// Text of a value as a plan has it: "299", "[2,40]", "true".
template <class Value>
std::string textOf(const Value& value) {
  return nlohmann::json(value).dump();
}
std::string textOf(const std::optional<double>& value) { return textOf(value.value()); }

template <class Value>
std::string argument(const std::string& option, const Value& value) {
  const std::string text = textOf(value);
  return "--" + option + "=" + (text.front() == '[' ? text.substr(1, text.size() - 2) : text);
}
std::string argument(const std::string& option, const std::vector<std::string>& list) {
  return "--" + option + "=" + pusht::joined(list, ",");
}
std::string argument(const std::string& option, bool value) { return (value ? "--" : "--no-") + option; }

/// Calls check(option, options) for each option, with options in which it alone is changed.
template <class Check>
void forEachChanged(const Check& check) {
  forEachOption([&](const auto& option) {
    SCOPED_TRACE(option.name);
    RunOptions options;
    change(option.of(options));
    ASSERT_NE(options, RunOptions());
    check(option, options);
  });
}

std::vector<std::string> namesOfOptions() {
  std::vector<std::string> names;
  forEachOption([&](const auto& option) { names.emplace_back(option.name); });
  return names;
}

RunConfiguration configurationOf(const RunOptions& options) {
  RunConfiguration configuration;
  static_cast<RunOptions&>(configuration.protocol) = options;
  configuration.policy = "expert";
  configuration.reference = {"mujoco", "MuJoCo"};
  configuration.engine = {"two_mass", "two-mass engine"};
  return configuration;
}

TEST(EveryOption, IsInTheTable) {
  EXPECT_THAT(namesOfOptions(),
              ::testing::ElementsAre("task", "seed", "first_episode", "episodes", "horizon", "floor", "reanchor",
                                     "model_variants", "closed_variants", "bound_position", "bound_angle", "repeats",
                                     "noise_seed", "independent_noise", "execute", "overlapping_starts",
                                     "until_decided", "target_coverage"));
}

TEST(EveryOption, ComesThroughAGoal) {
  forEachChanged([](const auto& /*option*/, const RunOptions& options) {
    LiveRequest request;
    request.services = {{"/reference", "/engine", "/engine_replay"}, "/policy"};
    EXPECT_EQ(merged(request, goalOf(options)).protocol, options);
    static_cast<RunOptions&>(request.protocol) = options;
    EXPECT_EQ(merged(request, pusht_msgs::CompareGoal()).protocol, options) << "a goal that says nothing";
    EXPECT_EQ(merged(request, goalOf(RunOptions())).protocol, RunOptions()) << "a goal can say each default";
  });
}

TEST(EveryOption, IsNamedByAGoalOnce) {
  const pusht_msgs::CompareGoal goal = goalOf(RunOptions());
  EXPECT_TRUE(oldFields(goal).empty());
  forEachOption([&](const auto& option) { EXPECT_TRUE(names(goal, option.name)) << option.name; });
}

TEST(OldFields, AreReadAsNamedOptions) {
  pusht_msgs::CompareGoal goal;
  goal.seed = {std::numeric_limits<std::uint64_t>::max()};
  goal.first_episode = {3};
  goal.episodes = {20};
  goal.horizon = {30};
  goal.until_decided = {0.5};
  goal.bound_position = {0.0125};
  goal.bound_angle = {0.25};
  goal.floor = {0};
  goal.reanchor = {1, 5};
  RunOptions expected;
  expected.seed = goal.seed.front();
  expected.first_episode = 3;
  expected.episodes = 20;
  expected.horizon = 30;
  expected.until_decided = 0.5;
  expected.bound_position = 0.0125;
  expected.bound_angle = 0.25;
  expected.floor = false;
  expected.reanchor = {1, 5};
  RunOptions options;
  setNamed(options, goal);
  EXPECT_EQ(options, expected);

  goal.options = {pusht::parameter("episodes", "1")};
  EXPECT_EQ(pusht::testing::refusalOf([&] { setNamed(options, goal); }),
            "option episodes 1: must be set once, by name or in the field of that name");
  goal.options.clear();
  goal.episodes = {20, 20};
  EXPECT_EQ(pusht::testing::refusalOf([&] { setNamed(options, goal); }),
            "episodes has 2 values: must have one, or none: then the parameter counts");
}

TEST(EveryOption, ComesThroughAGoalByName) {
  forEachChanged([](const auto& option, const RunOptions& options) {
    LiveRequest request;
    request.services = {{"/reference", "/engine", "/engine_replay"}, "/policy"};
    const pusht_msgs::RunOptions changed = describe(options);
    const pusht_msgs::RunOptions usual = describe(RunOptions());
    ASSERT_EQ(changed.values.size(), namesOfOptions().size());
    EXPECT_EQ(changed.descriptors, usual.descriptors);
    pusht_msgs::CompareGoal goal;
    for (std::size_t i = 0; i < changed.values.size(); ++i) {
      EXPECT_EQ(changed.descriptors[i].name, changed.values[i].name);
      EXPECT_EQ(changed.descriptors[i].default_value, usual.values[i].value);
      EXPECT_EQ(changed.values[i] != usual.values[i], changed.values[i].name == option.name);
      if (changed.values[i] != usual.values[i]) {
        goal.options = {changed.values[i]};
      }
    }
    EXPECT_EQ(merged(request, goal).protocol, options);
    goal.options = usual.values;
    static_cast<RunOptions&>(request.protocol) = options;
    EXPECT_EQ(merged(request, goal).protocol, RunOptions()) << "a goal can say each default";

    goal.options = {usual.values.front(), usual.values.front()};
    EXPECT_THAT(pusht::testing::refusalOf([&] { merged(request, goal); }), ::testing::HasSubstr("must be set once"));
  });
}

TEST(NamedOptions, AreRefusedWithNameAndRule) {
  const auto refusal = [](const std::string& name, const std::string& value) {
    pusht_msgs::CompareGoal goal;
    goal.options = {pusht::parameter(name, value)};
    RunOptions options;
    return pusht::testing::refusalOf([&] { setNamed(options, goal); });
  };
  EXPECT_EQ(refusal("epsiodes", "5"), "option 'epsiodes': unknown; known: " + pusht::joined(namesOfOptions()));
  EXPECT_EQ(refusal("episodes", "0"), "episodes 0: must be from 1 to 1000000");
  EXPECT_EQ(refusal("episodes", "99999999999"), "episodes 99999999999: must be from 1 to 1000000");
  EXPECT_EQ(refusal("horizon", "1e2"), "horizon '1e2': must be a decimal integer");
  EXPECT_EQ(refusal("seed", "-1"), "seed '-1': must be a decimal integer from 0 to 2^64 - 1");
  EXPECT_EQ(refusal("floor", "yes"), "floor 'yes': must be true or false");
  EXPECT_EQ(refusal("until_decided", "1.5"), "until_decided 1.5: must be from 0.0 to 1.0");
  EXPECT_EQ(refusal("bound_angle", "-1"), "bound_angle -1.0: must be at least 0.0 [rad]");
  EXPECT_EQ(refusal("reanchor", "1,x"), "reanchor '1,x': must be numbers of control steps like 1,5,20");
}

TEST(NamedOptions, LeaveASmokeRunItsOwnLength) {
  LiveRequest request;
  request.services = {{"/reference", "/engine", "/engine_replay"}, "/policy"};
  request.smoke = true;
  for (const char* const name : {"episodes", "horizon"}) {
    pusht_msgs::CompareGoal goal;
    goal.options = {pusht::parameter(name, "7")};
    EXPECT_EQ(pusht::testing::refusalOf([&] { merged(request, goal); }),
              "episodes and horizon: a smoke run has its own");
  }
}

TEST(EveryOption, ComesThroughACommandLine) {
  forEachChanged([](const auto& option, const RunOptions& options) {
    std::string name = option.name;
    std::replace(name.begin(), name.end(), '_', '-');
    RunOptions parsed;
    CLI::App app;
    declare(app, parsed);
    app.parse(argument(name, option.of(options)));
    EXPECT_EQ(parsed, options);
    EXPECT_NE(app.help().find("--" + name), std::string::npos);
    EXPECT_NE(app.help().find(std::string(option.meaning).substr(0, 20)), std::string::npos) << app.help();
  });
}

TEST(EveryOption, ComesThroughAPlanOrIsRefusedThere) {
  const pusht::testing::TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "plan.yaml";
  forEachChanged([&](const auto& option, const RunOptions& options) {
    const bool is_task = options.task != RunOptions().task;  // which other kinds hold
    std::ofstream(path) << (is_task ? "reference: gym_pusht\nengine: [chipmunk, box2d]\n" : "grid: {block_damp: [6]}\n")
                        << option.name << ": " << textOf(option.of(options)) << "\n";
    if (option.in_plan) {
      EXPECT_EQ(readSweepPlan(path).protocol, options);
    } else {
      const std::string refusal = pusht::testing::refusalOf([&] { readSweepPlan(path); });
      EXPECT_NE(refusal.find(option.name), std::string::npos) << refusal;
    }
  });
}

TEST(EveryOption, ComesThroughADescriptionAndItsHash) {
  const RunConfiguration usual = configurationOf(RunOptions());
  forEachChanged([&](const auto& option, const RunOptions& options) {
    const RunConfiguration changed = configurationOf(options);
    const RunConfiguration read = configurationFrom(describe(changed));
    EXPECT_EQ(read.protocol, options);
    const std::string name = option.name;
    const bool in_hash = name != "seed" && name != "first_episode";  // the course's hash has neither
    EXPECT_EQ(configurationHash(changed) != configurationHash(usual), in_hash);
    EXPECT_NE(describe(changed), describe(usual));
  });
}

TEST(EveryOption, IsInTheKeyOfKeptReferencesIfItDecidesWhatTheReferenceDoes) {
  forEachChanged([&](const auto& option, const RunOptions& options) {
    EXPECT_EQ(referenceOptions(options) != referenceOptions(RunOptions()), option.decides == Decides::kReference);
  });
}

/// Text of a default as compare.launch has it.
template <class Value>
std::string launchText(const Value& value) {
  return textOf(value);
}
std::string launchText(const std::string& value) { return value; }
std::string launchText(const std::vector<std::string>& value) { return pusht::joined(value, ","); }
std::string launchText(const std::vector<int>& value) { return value.empty() ? "none" : textOf(value); }
std::string launchText(const std::optional<double>& value) { return value ? textOf(value) : "0"; }

TEST(EveryOption, IsAnArgumentOfCompareLaunchWithItsDefault) {
  std::ifstream file(PUSHT_PACKAGES "/sim2sim_eval/launch/compare.launch");
  const std::string launch{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  forEachOption([&](const auto& option) {
    const std::string name = option.name;
    const RunOptions options;
    const std::string usual = launchText(option.of(options));
    EXPECT_NE(launch.find("<arg name=\"" + name + "\" default=\"" + usual + "\""), std::string::npos) << name << usual;
    EXPECT_NE(launch.find("<param name=\"" + name + "\""), std::string::npos) << name;
  });
}

}  // namespace
}  // namespace sim2sim
