// SPDX-License-Identifier: BSD-3-Clause
/// Controls of a replay: a slider over the steps of an episode, and a field for a seed to go to.
#pragma once

#include <QColor>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QSlider>
#include <QWidget>
#include <cstdint>
#include <optional>
#include <vector>

#include "episodes_model.hpp"

namespace pusht_rviz {

/// Slider with colored ticks.
class MarkedSlider : public QSlider {
  Q_OBJECT

 public:
  /// Tick of the slider: its value and color.
  struct Mark {
    int value = 0;
    QColor color;
  };

  explicit MarkedSlider(QWidget* parent = nullptr);
  void setMarks(std::vector<Mark> marks);
  const std::vector<Mark>& marks() const { return marks_; }

 protected:
  void paintEvent(QPaintEvent* event) override;

 private:
  std::vector<Mark> marks_;
};

/// Object names: scrubber, position, go_to_seed, go, go.refusal.
class ReplayControls : public QWidget {
  Q_OBJECT

 public:
  explicit ReplayControls(QWidget* parent = nullptr);

  /// Shows a position of the replay, and ticks where engine and replay leave the bound around the reference. `row` is
  /// that of the episode; null: it is not known.
  void show(std::uint64_t episode, std::uint32_t step, const EpisodeRow* row);

  /// Shows why the replay cannot go to the seed; empty: it can.
  void refuse(const QString& why);

  QString seed() const { return seed_->text().trimmed(); }

 Q_SIGNALS:
  void stepChosen(std::uint32_t step);
  void seedChosen();

 private:
  MarkedSlider* scrubber_;
  QLabel* position_;
  QLineEdit* seed_;
  QPushButton* go_;
  QLabel* refusal_;
};

}  // namespace pusht_rviz
