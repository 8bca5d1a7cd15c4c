// SPDX-License-Identifier: BSD-3-Clause
/// Result of the run so far.
#pragma once

#include <pusht_msgs/Summary.h>

#include <QLabel>
#include <QString>
#include <QWidget>

namespace pusht_rviz {

/// Headline, success rates, transfer, strip of episodes, and mean divergence. It computes nothing: figures come as
/// texts, in the digits of the terminal. Object names: headline, caveat, reference_success, engine_success, transfer,
/// pairs, mean_position, mean_angle.
class SummaryView : public QWidget {
  Q_OBJECT

 public:
  /// `strip` is shown below the figures, and becomes a child.
  explicit SummaryView(QWidget* strip, QWidget* parent = nullptr);

  void show(const pusht_msgs::Summary& summary);

 private:
  QLabel* headline_;
  QLabel* caveat_;
  QLabel* reference_;
  QLabel* engine_;
  QLabel* transfer_;
  QLabel* pairs_;
  QLabel* position_;
  QLabel* angle_;
};

}  // namespace pusht_rviz
