// SPDX-License-Identifier: BSD-3-Clause
/// Controls of the run under way: buttons, rate, progress.
#pragma once

#include <pusht_msgs/Progress.h>

#include <QComboBox>
#include <QIcon>
#include <QProgressBar>
#include <QPushButton>
#include <QWidget>

#include "buttons.hpp"

namespace pusht_rviz {

/// Object names: start, pause, step, cancel, rate, progress.
class RunControls : public QWidget {
  Q_OBJECT

 public:
  explicit RunControls(QWidget* parent = nullptr);

  /// Enables the buttons that make sense, and shows the progress.
  void show(const Situation& situation, const pusht_msgs::Progress& progress);

  /// Shows a rate [control steps/s], unless the list of rates is open; 0: as fast as possible.
  void showRate(double rate);

 Q_SIGNALS:
  void startPressed();
  void pausePressed();  ///< pause or resume
  void stepPressed();
  void cancelPressed();
  void rateChosen(double rate);  ///< [control steps/s]; 0: as fast as possible

 private:
  void showButtons(const Situation& situation);
  void showProgress(const Situation& situation, const pusht_msgs::Progress& progress);

  QPushButton* start_;
  QPushButton* pause_;
  QPushButton* step_;
  QPushButton* cancel_;
  QComboBox* rate_;
  QProgressBar* progress_;
  QIcon play_icon_;
  QIcon pause_icon_;
};

}  // namespace pusht_rviz
