// SPDX-License-Identifier: BSD-3-Clause
#include "next_run.hpp"

#include <gmock/gmock.h>

#include <QToolButton>
#include <limits>
#include <optional>
#include <string>

#include "headless.hpp"
#include "parameters.hpp"
#include "rows.hpp"

namespace pusht_rviz {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

void add(pusht_msgs::RunOptions& options, const std::string& name, const std::string& type, const std::string& value,
         double greatest = std::numeric_limits<double>::infinity()) {
  options.values.push_back(parameter(name, value));
  options.descriptors.emplace_back();
  options.descriptors.back().name = name;
  options.descriptors.back().type = type;
  options.descriptors.back().meaning = "what " + name + " is";
  options.descriptors.back().default_value = "0";
  options.descriptors.back().greatest = greatest;
}

/// An evaluator's options, of which the panel knows seed and first_episode alone.
pusht_msgs::RunOptions options() {
  pusht_msgs::RunOptions made;
  add(made, "seed", "integer", "100", 1e300);
  add(made, "first_episode", "integer", "3", 1e9);
  add(made, "action_delay", "integer", "1", 20.0);
  add(made, "noise", "boolean", "false");
  add(made, "stages", "text", "1,5");
  return made;
}

/// Simulator of one kind with one parameter, which the node has at 20.
pusht_msgs::DescribeResponse twoMass() {
  pusht_msgs::DescribeResponse made;
  made.success = 1;
  made.name = "two_mass";
  made.parameters = {parameter("block_damp", "20.0")};
  made.parameter_descriptors.emplace_back();
  made.parameter_descriptors.back().name = "block_damp";
  made.parameter_descriptors.back().type = "real";
  made.parameter_descriptors.back().default_value = "6.0";
  made.parameter_descriptors.back().least = 0.0;
  made.parameter_descriptors.back().greatest = 100.0;
  return made;
}

class NextRunTest : public testing::Test {
 protected:
  NextRunTest() {
    form_.setRequest(pusht_msgs::CompareGoal());
    form_.setOptions(options());
  }

  rviz::PropertyTreeWidget& tree() { return *form_.findChild<rviz::PropertyTreeWidget*>("tree"); }
  void type(const char* path, const QVariant& value) { ASSERT_TRUE(rowIn(tree(), path)->setValue(value)) << path; }
  std::string shown(const char* path) { return valueIn(tree(), path).toStdString(); }
  std::string rule(const char* path) { return ruleBelow(tree(), path).toStdString(); }
  pusht_msgs::CompareGoal goal() { return form_.goal(std::nullopt); }

  QApplication& application_ = headlessApplication();
  NextRun form_;
};

TEST_F(NextRunTest, HasARowForAnOptionThatItHasNeverHeardOf) {
  EXPECT_EQ(form_.waitsFor(), "");
  EXPECT_EQ(shown("run/action_delay"), "1") << "the evaluator's value";
  EXPECT_THAT(rowIn(tree(), "run/action_delay")->getViewData(0, Qt::ToolTipRole).toString().toStdString(),
              ::testing::HasSubstr("what action_delay is"));
  EXPECT_THAT(goal().options, IsEmpty());
  type("run/action_delay", "2");
  type("run/noise", true);
  type("run/stages", "1,5,20");
  EXPECT_THAT(goal().options,
              ElementsAre(parameter("action_delay", "2"), parameter("noise", "true"), parameter("stages", "1,5,20")));
}

TEST_F(NextRunTest, RefusesWhatTheOptionDoesNotTake) {
  type("run/action_delay", "21");
  EXPECT_EQ(rule("run/action_delay"), "action_delay 21: must be from 0 to 20");
  EXPECT_EQ(form_.refusal(), "action_delay 21: must be from 0 to 20");
  EXPECT_EQ(shown("run/action_delay"), "21") << "never corrected";
  type("run/action_delay", "many");
  EXPECT_EQ(rule("run/action_delay"), "action_delay 'many': must be a decimal integer");
  type("run/action_delay", "20");
  EXPECT_EQ(rule("run/action_delay"), "");
  EXPECT_EQ(form_.refusal(), "");
}

TEST_F(NextRunTest, CouplesFirstEpisodeAndSpawnSeed) {
  EXPECT_EQ(shown("spawn_seed"), "10103");
  type("run/first_episode", "5");
  EXPECT_EQ(shown("spawn_seed"), "10105");
  type("run/seed", "0");
  EXPECT_EQ(shown("spawn_seed"), "10005");
  type("spawn_seed", "10009");
  EXPECT_EQ(shown("run/first_episode"), "9");
  EXPECT_THAT(goal().options, ElementsAre(parameter("seed", "0"), parameter("first_episode", "9")));
  type("spawn_seed", "42");
  EXPECT_EQ(shown("run/first_episode"), "9");
  EXPECT_EQ(rule("spawn_seed"), "spawn seed '42': must be a whole number from 10000 + seed on, 10000");
  EXPECT_EQ(form_.refusal(), rule("spawn_seed"));
}

TEST_F(NextRunTest, HasNoSpawnSeedIfStartsAreGiven) {
  pusht_msgs::CompareGoal request;
  request.starts = {"starts.csv"};
  form_.setRequest(request);
  EXPECT_EQ(shown("spawn_seed"), "");
  EXPECT_EQ(form_.refusal(), "");
}

TEST_F(NextRunTest, SaysWhatIsShownAndNoMore) {
  pusht_msgs::CompareGoal expected;
  expected.out = {""};
  EXPECT_EQ(goal(), expected) << "the evaluator's own values count for the rest";
  EXPECT_EQ(form_.refusal(), "");
}

TEST_F(NextRunTest, NamesFolderPolicyRateAndSimulatorsThatWereChosen) {
  form_.setDescription(kEngine, "", twoMass());
  type("results", "mine");
  type("policy", "/my_policy");
  const pusht_msgs::CompareGoal goal = form_.goal(0.0);
  EXPECT_THAT(goal.out, ElementsAre("mine"));
  EXPECT_THAT(goal.policy_namespace, ElementsAre("/my_policy"));
  EXPECT_THAT(goal.rate, ElementsAre(0.0)) << "as fast as possible";
  EXPECT_THAT(goal.engine, ElementsAre("two_mass"));
  EXPECT_THAT(goal.engine_parameters, ElementsAre(parameter("block_damp", "20.0")));
  EXPECT_THAT(goal.reference, IsEmpty());
  type("engine/block_damp", "1000");
  EXPECT_EQ(form_.refusal(), "block_damp 1000.0: must be from 0.0 to 100.0");
}

TEST_F(NextRunTest, MovesOnToTheNextFolder) {
  pusht_msgs::CompareGoal request;
  request.out = {"mine"};
  form_.setRequest(request);
  form_.runBegan();
  EXPECT_THAT(goal().out, ElementsAre("mine-2"));
  request.overwrite = {1};
  form_.setRequest(request);
  form_.runBegan();
  EXPECT_THAT(goal().out, ElementsAre("mine"));
}

TEST_F(NextRunTest, TakesValuesBack) {
  form_.setDescription(kEngine, "", twoMass());
  type("engine/block_damp", "8");
  type("run/action_delay", "2");
  type("run/stages", "1");
  const auto reset = [&](const char* path) {
    tree().setCurrentIndex(tree().getModel()->indexOf(rowIn(tree(), path)));
    form_.findChild<QToolButton*>("reset")->click();
  };
  reset("engine/block_damp");
  EXPECT_EQ(shown("engine/block_damp"), "6.0");
  EXPECT_EQ(shown("run/action_delay"), "2") << "another row";
  reset("run");
  EXPECT_THAT(goal().options, IsEmpty()) << "all below it";
  EXPECT_FALSE(form_.findChild<QToolButton*>("reset")->isEnabled());
}

TEST_F(NextRunTest, BeginsAnewWithEachEvaluator) {
  type("run/action_delay", "2");
  form_.setRequest(pusht_msgs::CompareGoal());
  form_.setOptions(options());
  EXPECT_EQ(form_.waitsFor(), "");
  EXPECT_EQ(shown("run/action_delay"), "1");
}

TEST(NextRun, WaitsForTheOptions) {
  headlessApplication();
  NextRun form;
  EXPECT_NE(form.waitsFor(), "");
  form.setRequest(pusht_msgs::CompareGoal());
  EXPECT_NE(form.waitsFor(), "") << "its options are not known yet";
  form.setOptions(options());
  EXPECT_EQ(form.waitsFor(), "");
}

}  // namespace
}  // namespace pusht_rviz
