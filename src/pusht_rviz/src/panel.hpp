// SPDX-License-Identifier: BSD-3-Clause
/// The panel of rviz that drives a comparison.
#pragma once

#include <rviz/panel.h>

#include <QLabel>
#include <QString>
#include <QTabWidget>
#include <cstdint>
#include <optional>

#include "curves.hpp"
#include "episode_list.hpp"
#include "episode_strip.hpp"
#include "episodes_model.hpp"
#include "evaluator_link.hpp"
#include "next_run.hpp"
#include "node_row.hpp"
#include "replay_controls.hpp"
#include "run_controls.hpp"
#include "summary_view.hpp"
#include "view_buttons.hpp"

namespace pusht_rviz {

/// Connects the link to ROS with the widgets. Nothing here waits.
///
/// Every control has an object name, by which tests find it: status, tabs, tab_bar, views, and those that the headers
/// of the widgets name.
class Panel : public rviz::Panel {
  Q_OBJECT

 public:
  explicit Panel(QWidget* parent = nullptr);

  void onInitialize() override;
  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

  QSize sizeHint() const override;

 private:
  void buildLayout();
  void connectControls();
  void connectLink();
  void connectCurves();
  void connectGoals();

  void beginRun();
  void start();
  void command(const std::string& word);
  void goTo(std::uint64_t episode);

  Situation situation() const;
  void showState();
  void showStatus();
  void showReplay();
  void showStrip();
  void setReplay(bool replay);

  EvaluatorLink link_;

  RunControls* run_controls_;
  NodeRow* node_row_;
  QLabel* status_;
  ReplayControls* replay_controls_;
  ViewButtons* views_;
  QTabWidget* tabs_;
  EpisodesModel* episodes_;
  EpisodeStrip* strip_;
  SummaryView* summary_;
  Curves* curves_;
  NextRun* next_run_;
  EpisodeList* episode_list_;

  int width_ = 390;  // [px] until the user changes it
  bool replay_ = false;
  std::uint32_t last_run_ = 0;                 // number of the last run that has begun, as in Progress
  bool asked_ = false;                         // a goal was sent, and is not answered yet
  bool cancelling_ = false;                    // the run under way was told to end
  QString said_;                               // reason why the last command or goal was refused; empty: it was not
  std::optional<double> chosen_rate_;          // [control steps/s] by the user
  std::optional<double> request_rate_;         // [control steps/s] by the evaluator
  std::uint64_t shown_episode_ = 0;            // at the last divergence
  std::uint32_t shown_step_ = 0;               // at the last divergence
  std::optional<std::uint64_t> live_episode_;  // that the run under way has reached
};

}  // namespace pusht_rviz
