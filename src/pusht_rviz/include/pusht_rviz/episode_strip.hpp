// SPDX-License-Identifier: BSD-3-Clause
/// A square for each episode of a run, to be clicked.
#pragma once

#include <QWidget>
#include <cstdint>
#include <optional>

#include "pusht_rviz/episodes_model.hpp"
#include "pusht_rviz/strip_layout.hpp"

namespace pusht_rviz {

/// The left half of a square is the reference, the right half the engine: filled with the colour of the world where
/// the policy has succeeded, empty where it has failed, an outline alone where the episode has not finished.
class EpisodeStrip : public QWidget {
  Q_OBJECT

 public:
  /// `episodes` must outlive the strip, which follows it.
  explicit EpisodeStrip(const EpisodesModel* episodes, QWidget* parent = nullptr);

  /// The episodes of the run: their number, and the index of the first.
  void setRun(std::uint64_t episodes, std::uint64_t first);

  /// The episode that is under way, or shown.
  void setShown(std::uint64_t episode);

  /// The middle of an episode's square; none if it is not in sight.
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
