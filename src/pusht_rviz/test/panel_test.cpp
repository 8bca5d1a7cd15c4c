// SPDX-License-Identifier: BSD-3-Clause
/// Clicks through runs in a real rviz. Needs a display, a master, and what compare.launch starts with `start:=false
/// expert_node:=true`; waits for events, and never sleeps.
#include <gtest/gtest.h>
#include <pusht_msgs/Divergence.h>
#include <pusht_msgs/EpisodeResult.h>
#include <pusht_msgs/Progress.h>
#include <pusht_msgs/Summary.h>
#include <ros/init.h>
#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <rviz/display.h>
#include <rviz/panel_dock_widget.h>
#include <rviz/properties/property.h>
#include <rviz/visualization_frame.h>
#include <rviz/visualization_manager.h>

#include <QApplication>
#include <QComboBox>
#include <QElapsedTimer>
#include <QEventLoop>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QTabWidget>
#include <QTableView>
#include <QTest>
#include <QTimer>
#include <QToolButton>
#include <algorithm>
#include <csignal>
#include <functional>
#include <string>

#include "curves.hpp"
#include "episode_strip.hpp"
#include "rows.hpp"

namespace {

using pusht_rviz::Curves;
using pusht_rviz::EpisodeStrip;
using pusht_rviz::rowIn;
using pusht_rviz::ruleBelow;
using pusht_rviz::valueIn;

constexpr int kDeadline = 60'000;  // [ms] for what must come: it does so in a moment, on a busy machine later

/// Runs Qt's loop, in which rviz serves ROS, until `condition` holds; false if it never does.
bool waitUntil(const std::function<bool()>& condition) {
  QElapsedTimer elapsed;
  elapsed.start();
  QEventLoop loop;
  QTimer wake;  // what is waited for may be no event of Qt's
  wake.start(5);
  while (!condition()) {
    if (elapsed.elapsed() > kDeadline) {
      return false;
    }
    loop.processEvents(QEventLoop::WaitForMoreEvents);
  }
  return true;
}

/// rviz with the panel, and what the evaluator says meanwhile.
class PanelTest : public testing::Test {
 protected:
  PanelTest() {
    frame_.setSplashPath("");
    frame_.initialize();
    frame_.resize(1366, 768);
    dock_ = frame_.addPanelByName("Comparison", "pusht_rviz/Comparison");
    frame_.show();
    frame_.getManager()->setFixedFrame("world");
    picture_ = frame_.getManager()->createDisplay("rviz/MarkerArray", "Picture", true);
    picture_->subProp("Marker Topic")->setValue("/sim2sim/markers");
    progress_topic_ = node_.subscribe<pusht_msgs::Progress>(
        "/sim2sim/progress", 1000,
        boost::function<void(const pusht_msgs::ProgressConstPtr&)>([this](const auto& message) {
          progress_ = *message;
          was_busy_ = was_busy_ || progress_.busy != 0;
        }));
    divergence_topic_ =
        node_.subscribe<pusht_msgs::Divergence>("/sim2sim/divergence", 1000,
                                                boost::function<void(const pusht_msgs::DivergenceConstPtr&)>(
                                                    [this](const auto& message) { divergence_ = *message; }));
    summary_topic_ = node_.subscribe<pusht_msgs::Summary>("/sim2sim/summary", 1000,
                                                          boost::function<void(const pusht_msgs::SummaryConstPtr&)>(
                                                              [this](const auto& message) { summary_ = *message; }));
    episode_topic_ = node_.subscribe<pusht_msgs::EpisodeResult>(
        "/sim2sim/episode", 1000,
        boost::function<void(const pusht_msgs::EpisodeResultConstPtr&)>([this](const auto&) { ++episodes_; }));
  }

  /// Waits until the topics are connected: a short run may be over before its first episode is heard of.
  void SetUp() override {
    for (const ros::Subscriber* topic : {&progress_topic_, &divergence_topic_, &summary_topic_, &episode_topic_}) {
      ASSERT_TRUE(waitUntil([&] { return topic->getNumPublishers() > 0; })) << topic->getTopic();
    }
  }

  template <class Widget>
  Widget* find(const char* name) {
    auto* const widget = dock_->findChild<Widget*>(name);
    EXPECT_NE(widget, nullptr) << name;
    return widget;
  }

  /// Once it can be pressed.
  void click(const char* name) {
    auto* const button = find<QPushButton>(name);
    ASSERT_TRUE(waitUntil([&] { return button->isVisible() && button->isEnabled(); }))
        << name << " cannot be pressed: " << button->toolTip().toStdString() << "; "
        << find<QLabel>("status")->text().toStdString();
    QTest::mouseClick(button, Qt::LeftButton);
  }

  rviz::PropertyTreeWidget& tree() { return *find<rviz::PropertyTreeWidget>("tree"); }

  /// Opens the editor of a row as a user does, once the row is there. `path`: "engine/block_damp".
  template <class Editor>
  Editor* edit(const char* path) {
    if (!waitUntil([&] { return tree().isVisible() && rowIn(tree(), path) != nullptr; })) {
      ADD_FAILURE() << path << ": no such row";
      return nullptr;
    }
    const QModelIndex row = tree().getModel()->indexOf(rowIn(tree(), path));
    const QModelIndex value = row.sibling(row.row(), 1);
    tree().scrollTo(value);
    QTest::mouseClick(tree().viewport(), Qt::LeftButton, Qt::NoModifier, tree().visualRect(value).center());
    Editor* editor = nullptr;
    EXPECT_TRUE(waitUntil([&] {
      editor = tree().viewport()->findChild<Editor*>();
      return editor != nullptr && editor->isVisible();
    })) << path;
    return editor;
  }

  void type(const char* path, const char* text) {
    auto* const field = edit<QLineEdit>(path);
    ASSERT_NE(field, nullptr);
    field->selectAll();
    QTest::keyClicks(field, text);
    QTest::keyClick(field, Qt::Key_Return);
    ASSERT_TRUE(waitUntil([&] {
      return tree().viewport()->findChild<QLineEdit*>() == nullptr && valueIn(tree(), path) == text;
    })) << path;
  }

  void chooseRate(double rate) {
    auto* const combo = find<QComboBox>("rate");
    ASSERT_TRUE(waitUntil([&] { return combo->isEnabled(); }));
    const int index = combo->findData(rate);
    ASSERT_GE(index, 0);
    combo->setCurrentIndex(index);
    Q_EMIT combo->activated(index);
  }

  void choosePolicy(const char* name) {
    auto* const combo = edit<QComboBox>("policy");
    ASSERT_NE(combo, nullptr);
    ASSERT_GE(combo->findText(name), 0) << name;
    combo->setCurrentText(name);
    EXPECT_EQ(valueIn(tree(), "policy"), name);
    QTest::keyClick(combo, Qt::Key_Return);
    ASSERT_TRUE(waitUntil([&] { return tree().viewport()->findChild<QComboBox*>() == nullptr; }));
  }

  void openTab(int index) { find<QTabWidget>("tabs")->setCurrentIndex(index); }

  rviz::VisualizationFrame frame_;
  QDockWidget* dock_ = nullptr;
  rviz::Display* picture_ = nullptr;
  ros::NodeHandle node_;
  ros::Subscriber progress_topic_;
  ros::Subscriber divergence_topic_;
  ros::Subscriber summary_topic_;
  ros::Subscriber episode_topic_;
  pusht_msgs::Progress progress_;
  bool was_busy_ = false;
  pusht_msgs::Divergence divergence_;
  pusht_msgs::Summary summary_;
  int episodes_ = 0;
};

constexpr int kThisRun = 0;
constexpr int kNextRun = 1;

TEST_F(PanelTest, DrivesARunThroughEveryButton) {
  auto* const start = find<QPushButton>("start");
  ASSERT_TRUE(waitUntil([&] { return start->isEnabled(); })) << start->toolTip().toStdString();

  // What cannot be is refused beside its field, and keeps Start from being pressed.
  openTab(kNextRun);
  type("spawn_seed", "42");
  EXPECT_FALSE(start->isEnabled());
  EXPECT_EQ(ruleBelow(tree(), "spawn_seed"), "spawn seed '42': must be a whole number from 10000 + seed on, 10000");
  type("spawn_seed", "10001");
  type("engine/block_damp", "1000");
  EXPECT_FALSE(start->isEnabled());
  EXPECT_EQ(ruleBelow(tree(), "engine/block_damp"), "block_damp 1000.0: must be from 0.0 to 100.0 [1/s]");
  type("engine/block_damp", "6");
  EXPECT_EQ(valueIn(tree(), "run/first_episode"), "1");
  type("run/episodes", "2");
  choosePolicy("/expert");
  ASSERT_TRUE(start->isEnabled()) << start->toolTip().toStdString();

  // A slow run that is paused, stepped, reset in mid-run, resumed and cancelled.
  chooseRate(10.0);
  click("start");
  ASSERT_TRUE(waitUntil([&] { return progress_.busy != 0; }));
  EXPECT_TRUE(waitUntil([&] { return !start->isEnabled(); }));
  EXPECT_TRUE(waitUntil([&] { return find<QTabWidget>("tabs")->currentIndex() == kThisRun; }));
  click("pause");
  ASSERT_TRUE(waitUntil([&] { return progress_.paused != 0; }));
  const auto step_of = [&] { return divergence_.step; };
  const std::uint32_t held = step_of();  // or one more, which was under way: two clicks are more than that
  for (const std::uint32_t step : {held + 1, held + 2}) {
    click("step");
    ASSERT_TRUE(waitUntil([&] { return step_of() >= step; })) << step_of();
  }
  const QList<QToolButton*> tools = frame_.findChildren<QToolButton*>();
  const auto reset =
      std::find_if(tools.begin(), tools.end(), [](const QToolButton* tool) { return tool->text() == "Reset"; });
  ASSERT_NE(reset, tools.end());
  const auto drawn = [&] { return picture_->subProp("Namespaces")->numChildren(); };
  ASSERT_TRUE(waitUntil([&] { return drawn() > 0; }));
  QTest::mouseClick(*reset, Qt::LeftButton);
  EXPECT_EQ(drawn(), 0) << "rviz has forgotten all of it";
  EXPECT_TRUE(waitUntil([&] { return drawn() > 0; })) << "though the run stands still";
  EXPECT_NE(progress_.busy, 0) << "rviz's Reset ends no run";
  EXPECT_NE(progress_.paused, 0);
  click("pause");
  ASSERT_TRUE(waitUntil([&] { return progress_.paused == 0; }));
  click("cancel");
  ASSERT_TRUE(waitUntil([&] { return progress_.busy == 0; }));
  EXPECT_NE(progress_.failure, "") << "it was cancelled";
  ASSERT_TRUE(waitUntil([&] { return find<QLabel>("status")->isVisible(); }));

  // A run at full speed, to its end.
  episodes_ = 0;
  was_busy_ = false;
  chooseRate(0.0);
  click("start");
  ASSERT_TRUE(waitUntil([&] { return was_busy_; }));
  ASSERT_TRUE(waitUntil([&] { return progress_.busy == 0; }));
  EXPECT_EQ(progress_.failure, "");
  EXPECT_EQ(progress_.episodes_finished, 2U);
  ASSERT_TRUE(waitUntil([&] { return episodes_ == 2 && summary_.episodes_finished == 2; }));
  EXPECT_TRUE(waitUntil([&] { return find<QTableView>("episode_list")->model()->rowCount() == 2; }));
  const QString rate = QString::number(summary_.reference.successes) + "/2  ";
  EXPECT_TRUE(waitUntil([&] { return find<QLabel>("reference_success")->text().startsWith(rate); }))
      << find<QLabel>("reference_success")->text().toStdString();
  EXPECT_EQ(find<QLabel>("headline")->text().toStdString(), summary_.headline);
  EXPECT_FALSE(find<QLabel>("caveat")->isVisibleTo(dock_)) << "of two episodes nothing is said";

  // A click on a square shows the curves of that episode.
  auto* const strip = find<EpisodeStrip>("episode_strip");
  auto* const curves = dock_->findChild<Curves*>();
  ASSERT_NE(curves, nullptr);
  EXPECT_EQ(curves->chosen(), 2U);
  ASSERT_TRUE(waitUntil([&] { return strip->isVisible() && strip->centerOf(2); }));
  QTest::mouseClick(strip, Qt::LeftButton, Qt::NoModifier, *strip->centerOf(1));
  EXPECT_EQ(curves->chosen(), 1U);
  QTest::mouseClick(strip, Qt::LeftButton, Qt::NoModifier, *strip->centerOf(2));
  EXPECT_EQ(curves->chosen(), 2U);
}

/// With the environment variable PANEL_TEST_SMOKE: an evaluator of a smoke run, which has its own number of episodes.
TEST_F(PanelTest, ShowsWhyTheEvaluatorRefusesARun) {
  if (!qEnvironmentVariableIsSet("PANEL_TEST_SMOKE")) {
    GTEST_SKIP() << "no smoke run";
  }
  auto* const start = find<QPushButton>("start");
  ASSERT_TRUE(waitUntil([&] { return start->isEnabled(); })) << start->toolTip().toStdString();
  openTab(kNextRun);
  type("run/episodes", "3");
  click("start");
  ASSERT_TRUE(waitUntil([&] {
    return find<QLabel>("status")->text() == "episodes and horizon: a smoke run has its own";
  })) << find<QLabel>("status")->text().toStdString();
  EXPECT_EQ(find<QTabWidget>("tabs")->currentIndex(), kNextRun) << "where it can be mended";
  type("run/episodes", "2");

  // A goal that fails before its run begins leaves the folder to the next one.
  const QString folder = valueIn(tree(), "results");
  type("results", "/proc/none/out");
  click("start");
  const auto failed = [&] { return find<QLabel>("status")->text().contains("cannot create /proc/none"); };
  ASSERT_TRUE(waitUntil(failed)) << find<QLabel>("status")->text().toStdString();
  EXPECT_EQ(valueIn(tree(), "results"), "/proc/none/out");
  openTab(kNextRun);
  type("results", folder.toStdString().c_str());
  click("start");
  ASSERT_TRUE(waitUntil([&] { return episodes_ == 2; }));
  EXPECT_TRUE(waitUntil([&] { return valueIn(tree(), "results") == folder + "-2"; }))
      << "a folder takes one run: " << valueIn(tree(), "results").toStdString();
  ASSERT_TRUE(waitUntil([&] { return progress_.busy == 0; })) << "its results are written";
}

/// With the environment variable PANEL_TEST_VICTIM: the process that plays the engine. It is killed.
TEST_F(PanelTest, ShowsANodeThatDiesAndGoesOn) {
  const int victim = qEnvironmentVariableIntValue("PANEL_TEST_VICTIM");
  if (victim == 0) {
    GTEST_SKIP() << "no process to kill";
  }
  const auto* const engine = find<QLabel>("node.engine");
  chooseRate(10.0);
  click("start");
  ASSERT_TRUE(waitUntil([&] { return engine->toolTip().contains("busy"); })) << engine->toolTip().toStdString();
  QElapsedTimer since;
  since.start();
  ASSERT_EQ(kill(victim, SIGKILL), 0);
  ASSERT_TRUE(waitUntil([&] { return engine->toolTip().contains("lost"); })) << engine->toolTip().toStdString();
  EXPECT_LT(since.elapsed(), 1000) << "[ms]";
  RecordProperty("lost_after_ms", static_cast<int>(since.elapsed()));
  ASSERT_TRUE(waitUntil([&] { return progress_.busy == 0; }));
  EXPECT_NE(progress_.failure.find("engine"), std::string::npos) << progress_.failure;
  EXPECT_TRUE(waitUntil([&] { return find<QLabel>("status")->text().contains("engine: lost"); }));
  EXPECT_TRUE(waitUntil([&] { return find<QLabel>("node.reference")->toolTip().contains("alive"); }))
      << find<QLabel>("node.reference")->toolTip().toStdString();
}

/// With the environment variable PANEL_TEST_EVALUATOR: the process of the evaluator. It is stopped, goes on, is killed.
TEST_F(PanelTest, ShowsAnEvaluatorThatHangsAndDies) {
  const int victim = qEnvironmentVariableIntValue("PANEL_TEST_EVALUATOR");
  if (victim == 0) {
    GTEST_SKIP() << "no process to kill";
  }
  const auto* const evaluator = find<QLabel>("node.evaluator");
  const auto becomes = [&](const char* word) { return waitUntil([&] { return evaluator->toolTip().contains(word); }); };
  const auto* const start = find<QPushButton>("start");
  ASSERT_TRUE(waitUntil([&] { return start->isEnabled(); })) << start->toolTip().toStdString();
  ASSERT_EQ(kill(victim, SIGSTOP), 0);
  ASSERT_TRUE(becomes("gives no answer")) << evaluator->toolTip().toStdString();
  EXPECT_FALSE(find<QLabel>("node.reference")->toolTip().contains("alive")) << "nothing is known of it now";
  EXPECT_FALSE(start->isEnabled());
  ASSERT_EQ(kill(victim, SIGCONT), 0);
  ASSERT_TRUE(becomes("alive")) << evaluator->toolTip().toStdString();
  EXPECT_TRUE(waitUntil([&] { return start->isEnabled(); })) << start->toolTip().toStdString();
  ASSERT_EQ(kill(victim, SIGKILL), 0);
  ASSERT_TRUE(becomes("lost")) << evaluator->toolTip().toStdString();
  EXPECT_FALSE(start->isEnabled());
  EXPECT_EQ(start->toolTip(), "waiting for the evaluator");
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "panel_test", ros::init_options::AnonymousName);
  const ros::NodeHandle keeps_ros_up;
  const QApplication application(argc, argv);
  return RUN_ALL_TESTS();
}
