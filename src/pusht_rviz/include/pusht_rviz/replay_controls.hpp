// SPDX-License-Identifier: BSD-3-Clause
/// What a replay has besides: a slider over the steps of an episode, and a field for a seed.
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

#include "pusht_rviz/episodes_model.hpp"

namespace pusht_rviz {

/// A slider with coloured ticks.
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

  /// Where the replay is; `row`: of its episode, none if that is not known. Ticks say where engine and replay leave the
  /// bound around the reference.
  void show(std::uint64_t episode, std::uint32_t step, const EpisodeRow* row);

  /// Why a seed cannot be gone to; empty: it can.
  void refuse(const QString& why);

  QString seed() const { return seed_->text().trimmed(); }

 Q_SIGNALS:
  void stepChosen(std::uint32_t step);
  void seedChosen();

 private:
  MarkedSlider* scrubber_;
  QLabel* place_;
  QLineEdit* seed_;
  QPushButton* go_;
  QLabel* refusal_;
};

}  // namespace pusht_rviz
