// SPDX-License-Identifier: BSD-3-Clause
#include "next_run.hpp"

#include <gmock/gmock.h>

#include <QCheckBox>
#include <QEvent>
#include <QLabel>
#include <QLineEdit>
#include <limits>
#include <string>

#include "headless.hpp"
#include "parameters.hpp"

namespace pusht_rviz {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

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

class NextRunTest : public testing::Test {
 protected:
  NextRunTest() {
    form_.setRequest(pusht_msgs::CompareGoal());
    form_.setOptions(options());
  }

  template <class Widget>
  Widget* find(const QString& name) {
    QApplication::sendPostedEvents(nullptr, QEvent::DeferredDelete);  // those of the form before
    return form_.findChild<Widget*>(name);
  }
  void type(const char* name, const char* text) { find<QLineEdit>(name)->setText(text); }
  QString shown(const char* name) { return find<QLineEdit>(name)->text(); }

  QApplication& application_ = headlessApplication();
  NextRun form_;
};

TEST_F(NextRunTest, HasAFieldForAnOptionThatItHasNeverHeardOf) {
  EXPECT_EQ(form_.waitsFor(), "");
  EXPECT_EQ(shown("action_delay"), "1") << "the evaluator's value";
  EXPECT_THAT(find<QLineEdit>("action_delay")->toolTip().toStdString(), ::testing::HasSubstr("what action_delay is"));
  EXPECT_THAT(goalFrom(form_.draft()).goal.options, IsEmpty());
  type("action_delay", "2");
  find<QCheckBox>("noise")->setChecked(true);
  type("stages", "1,5,20");
  EXPECT_THAT(goalFrom(form_.draft()).goal.options,
              ElementsAre(parameter("action_delay", "2"), parameter("noise", "true"), parameter("stages", "1,5,20")));
}

TEST_F(NextRunTest, RefusesWhatTheOptionDoesNotTake) {
  type("action_delay", "21");
  EXPECT_EQ(find<QLabel>("action_delay.refusal")->text(), "action_delay 21: must be from 0 to 20");
  EXPECT_THAT(goalFrom(form_.draft()).refusals, SizeIs(1));
}

TEST_F(NextRunTest, CouplesFirstEpisodeAndSpawnSeed) {
  EXPECT_EQ(shown("spawn_seed"), "10103");
  type("first_episode", "5");
  EXPECT_EQ(shown("spawn_seed"), "10105");
  type("seed", "0");
  EXPECT_EQ(shown("spawn_seed"), "10005");
  type("spawn_seed", "10009");
  EXPECT_EQ(shown("first_episode"), "9");
  EXPECT_THAT(goalFrom(form_.draft()).goal.options,
              ElementsAre(parameter("seed", "0"), parameter("first_episode", "9")));
  type("spawn_seed", "42");
  EXPECT_EQ(shown("first_episode"), "9");
  EXPECT_THAT(find<QLabel>("spawn_seed.refusal")->text().toStdString(), ::testing::HasSubstr("spawn seed '42'"));
}

TEST_F(NextRunTest, BeginsAnewWithEachEvaluator) {
  type("action_delay", "2");
  form_.setRequest(pusht_msgs::CompareGoal());
  form_.setOptions(options());
  EXPECT_EQ(form_.waitsFor(), "");
  EXPECT_EQ(shown("action_delay"), "1");
}

TEST(NextRun, WaitsForTheOptions) {
  const QApplication& application = headlessApplication();
  static_cast<void>(application);
  NextRun form;
  EXPECT_NE(form.waitsFor(), "");
  form.setRequest(pusht_msgs::CompareGoal());
  EXPECT_NE(form.waitsFor(), "") << "its options are not known yet";
  form.setOptions(options());
  EXPECT_EQ(form.waitsFor(), "");
}

}  // namespace
}  // namespace pusht_rviz
