// SPDX-License-Identifier: BSD-3-Clause
/// The answer: what a run says so far.
#pragma once

#include <pusht_msgs/Summary.h>

#include <QLabel>
#include <QString>
#include <QWidget>

namespace pusht_rviz {

/// The headline, success rates, transfer, a square for each episode, mean divergence, as the terminal prints them.
/// Computes nothing.
class SummaryView : public QWidget {
  Q_OBJECT

 public:
  /// `strip` is shown between figures and counts; it becomes a child.
  explicit SummaryView(QWidget* strip, QWidget* parent = nullptr);

  void show(const pusht_msgs::Summary& summary);
  void clear();

 private:
  QLabel* headline_;
  QLabel* reference_;
  QLabel* engine_;
  QLabel* transfer_;
  QLabel* pairs_;
  QLabel* position_;
  QLabel* angle_;
};

}  // namespace pusht_rviz
