// SPDX-License-Identifier: BSD-3-Clause
/// The answer: what a run says so far.
#pragma once

#include <pusht_msgs/Summary.h>

#include <QLabel>
#include <QString>
#include <QWidget>

namespace pusht_rviz {

/// Success rates, transfer, the table of pairs, mean divergence, as the terminal prints them. Computes nothing.
class SummaryView : public QWidget {
  Q_OBJECT

 public:
  explicit SummaryView(QWidget* parent = nullptr);

  void show(const pusht_msgs::Summary& summary);
  void clear();

 private:
  QLabel* reference_;
  QLabel* engine_;
  QLabel* transfer_;
  QLabel* both_;
  QLabel* only_reference_;
  QLabel* only_engine_;
  QLabel* neither_;
  QLabel* position_;
  QLabel* angle_;
};

}  // namespace pusht_rviz
