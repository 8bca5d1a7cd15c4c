// SPDX-License-Identifier: BSD-3-Clause
/// The panel of rviz that drives a comparison.
#pragma once

#include <pusht_msgs/DescribeResponse.h>
#include <rviz/panel.h>

#include <QComboBox>
#include <QIcon>
#include <QLabel>
#include <QLineEdit>
#include <QProgressBar>
#include <QPushButton>
#include <QSlider>
#include <QString>
#include <QTabWidget>
#include <QTableView>
#include <array>
#include <cstdint>
#include <optional>

#include "pusht_rviz/curves.hpp"
#include "pusht_rviz/episode_strip.hpp"
#include "pusht_rviz/episodes_model.hpp"
#include "pusht_rviz/evaluator_link.hpp"
#include "pusht_rviz/next_run.hpp"
#include "pusht_rviz/replay_controls.hpp"
#include "pusht_rviz/summary_view.hpp"
#include "pusht_rviz/view_buttons.hpp"

namespace pusht_rviz {

/// Puts the parts together: the link to ROS on one side, widgets on the other. Nothing here waits for anybody.
///
/// Every control has an object name, so that a test finds it: start, pause, step, cancel, rate, progress, status,
/// node.ROLE, tabs, scrubber, go_to_seed, go, go.refusal, episode_list, and those of the parts.
class Panel : public rviz::Panel {
  Q_OBJECT

 public:
  explicit Panel(QWidget* parent = nullptr);

  void onInitialize() override;
  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

  QSize sizeHint() const override;

 private:
  void buildControls();
  void buildTabs();
  void connectLink();

  void start();
  void pauseOrResume();
  void chooseRate();
  void goTo(std::uint64_t episode);
  void goToRow(int row);
  void goToSeed();

  void showState();
  void showProgress();
  void showRate();
  void showStatus();
  void showNode(std::size_t role);
  void showScrubber();
  void showStrip();
  void setReplay(bool replay);

  EvaluatorLink link_;

  QPushButton* start_;
  QPushButton* pause_;
  QPushButton* step_;
  QPushButton* cancel_;
  QComboBox* rate_;
  QProgressBar* progress_;
  std::array<QLabel*, kRoles> nodes_{};
  QLabel* status_;
  ViewButtons* views_;
  ReplayControls* replay_controls_;
  QTabWidget* tabs_;
  EpisodesModel* episodes_;
  EpisodeStrip* strip_;
  SummaryView* summary_;
  Curves* curves_;
  NextRun* next_run_;
  QTableView* episode_list_;
  QPushButton* go_to_episode_;
  QIcon play_icon_;
  QIcon pause_icon_;

  int width_ = 390;  // [px] at first
  bool replay_ = false;
  std::uint32_t last_run_ = 0;              // number of the last run that has begun, as in Progress
  bool asked_ = false;                      // a goal was sent, and is not answered yet
  bool cancelling_ = false;                 // the run under way
  QString refusal_;                         // the first rule that the form breaks
  QString said_;                            // why something that was asked for was refused
  std::optional<double> chosen_rate_;       // [control steps/s], by who sits here
  std::optional<double> request_rate_;      // the evaluator's own
  std::array<std::string, kRoles> faults_;  // with which nodes started, if they did not come up
  std::array<QString, kRoles> titles_;
  std::uint64_t shown_episode_ = 0;
  std::uint32_t shown_step_ = 0;
  std::optional<std::uint64_t> live_episode_;  // the last of which the run has told, if of any
};

}  // namespace pusht_rviz
