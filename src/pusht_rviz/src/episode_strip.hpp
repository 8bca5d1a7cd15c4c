// SPDX-License-Identifier: BSD-3-Clause
/// Strip of squares, one for each episode of a run, to be clicked.
#pragma once

#include <QWidget>
#include <cstdint>
#include <optional>

#include "episodes_model.hpp"
#include "strip_layout.hpp"

namespace pusht_rviz {

/// The left half of a square is the reference, the right half the engine. A half is filled with the color of its world
/// if the policy has succeeded there. An episode that has not finished is an outline.
class EpisodeStrip : public QWidget {
  Q_OBJECT

 public:
  /// Follows `episodes`, which must outlive the strip.
  explicit EpisodeStrip(const EpisodesModel* episodes, QWidget* parent = nullptr);

  /// Sets the number of episodes of the run and the index of the first.
  void setRun(std::uint64_t episodes, std::uint64_t first);

  /// Marks the episode that is under way, or that is shown.
  void setShown(std::uint64_t episode);

  /// Center of an episode's square [px]; none if it is not in sight.
  std::optional<QPoint> centerOf(std::uint64_t episode) const;

  int heightForWidth(int width) const override;
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override;

 Q_SIGNALS:
  void clicked(std::uint64_t episode);

 protected:
  void paintEvent(QPaintEvent* event) override;
  void mousePressEvent(QMouseEvent* event) override;
  bool event(QEvent* event) override;

 private:
  StripLayout layout(int width) const;
  std::uint64_t count() const;
  std::optional<std::uint64_t> episodeAt(const QPoint& at) const;
  QString toolTipOf(std::uint64_t episode) const;

  const EpisodesModel* episodes_;
  std::uint64_t expected_ = 0;
  std::uint64_t first_ = 0;
  std::uint64_t shown_ = 0;
};

}  // namespace pusht_rviz
