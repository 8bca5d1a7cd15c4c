// SPDX-License-Identifier: BSD-3-Clause
/// Controls of a replay: a slider over the steps of an episode.
#pragma once

#include <QColor>
#include <QLabel>
#include <QSlider>
#include <QWidget>
#include <cstdint>
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

/// Object names: scrubber, position.
class ReplayControls : public QWidget {
  Q_OBJECT

 public:
  explicit ReplayControls(QWidget* parent = nullptr);

  /// Shows a position of the replay, and ticks where engine and replay leave the bound around the reference. `row` is
  /// that of the episode; null: it is not known.
  void show(std::uint64_t episode, std::uint32_t step, const EpisodeRow* row);

 Q_SIGNALS:
  void stepChosen(std::uint32_t step);

 private:
  MarkedSlider* scrubber_;
  QLabel* position_;
};

}  // namespace pusht_rviz
