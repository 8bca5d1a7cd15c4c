// SPDX-License-Identifier: BSD-3-Clause
#include "episode_strip.hpp"

#include <QHelpEvent>
#include <QMouseEvent>
#include <QPainter>
#include <QSizePolicy>
#include <QToolTip>
#include <algorithm>

#include "theme.hpp"

namespace pusht_rviz {
namespace {

constexpr int kLeast = 6;      // [px] pitch of the squares of a long run
constexpr int kGreatest = 16;  // [px] pitch of the squares of a short run
constexpr int kMostRows = 3;   // of squares of the greatest pitch: the greatest height of the strip
constexpr int kGap = 2;        // [px] between squares

}  // namespace

EpisodeStrip::EpisodeStrip(const EpisodesModel* episodes, QWidget* parent) : QWidget(parent), episodes_(episodes) {
  setObjectName("episode_strip");
  setCursor(Qt::PointingHandCursor);
  QSizePolicy policy(QSizePolicy::Expanding, QSizePolicy::Preferred);
  policy.setHeightForWidth(true);
  setSizePolicy(policy);
  const auto follow = [this] {
    updateGeometry();
    update();
  };
  connect(episodes_, &QAbstractItemModel::rowsInserted, this, follow);
  connect(episodes_, &QAbstractItemModel::modelReset, this, follow);
  connect(episodes_, &QAbstractItemModel::dataChanged, this, follow);
}

void EpisodeStrip::setRun(std::uint64_t episodes, std::uint64_t first) {
  if (episodes != expected_ || first != first_) {
    expected_ = episodes;
    first_ = first;
    updateGeometry();
    update();
  }
}

void EpisodeStrip::setShown(std::uint64_t episode) {
  if (episode != shown_) {
    shown_ = episode;
    update();
  }
}

std::uint64_t EpisodeStrip::count() const {
  return std::max(expected_, static_cast<std::uint64_t>(episodes_->rowCount()));
}

StripLayout EpisodeStrip::layout(int width) const {
  const std::uint64_t shown = shown_ < first_ ? 0 : shown_ - first_;
  return layOut(count(), shown, width, theme::px(kGreatest) * kMostRows, theme::px(kLeast), theme::px(kGreatest));
}

int EpisodeStrip::heightForWidth(int width) const {
  const StripLayout layout = this->layout(width);
  return layout.pitch * std::max(1, layout.rows());
}

QSize EpisodeStrip::sizeHint() const { return {theme::px(360), heightForWidth(std::max(width(), theme::px(200)))}; }

QSize EpisodeStrip::minimumSizeHint() const { return {theme::px(100), sizeHint().height()}; }

std::optional<QPoint> EpisodeStrip::centerOf(std::uint64_t episode) const {
  const StripLayout layout = this->layout(width());
  const std::uint64_t index = episode - first_;
  if (episode < first_ || index < layout.begin || index >= layout.end) {
    return std::nullopt;
  }
  return QPoint(layout.left(index) + layout.pitch / 2, layout.top(index) + layout.pitch / 2);
}

std::optional<std::uint64_t> EpisodeStrip::episodeAt(const QPoint& at) const {
  const std::optional<std::uint64_t> index = layout(width()).indexAt(at.x(), at.y());
  return index ? std::optional(first_ + *index) : std::nullopt;
}

void EpisodeStrip::paintEvent(QPaintEvent* /*event*/) {
  QPainter painter(this);
  const StripLayout layout = this->layout(width());
  const int side = layout.pitch - kGap;
  for (std::uint64_t index = layout.begin; index < layout.end; ++index) {
    const std::uint64_t episode = first_ + index;
    const QRect square(layout.left(index) + kGap / 2, layout.top(index) + kGap / 2, side, side);
    if (const std::optional<int> row = episodes_->rowOfEpisode(episode)) {
      const EpisodeRow& outcome = episodes_->row(*row);
      painter.fillRect(square, theme::kGrid);
      const QRect left(square.left(), square.top(), side / 2, side);
      const QRect right(square.left() + side / 2, square.top(), side - side / 2, side);
      if (outcome.reference.success) {
        painter.fillRect(left, theme::kReference);
      }
      if (outcome.engine.success) {
        painter.fillRect(right, theme::kEngine);
      }
    } else {
      painter.setPen(theme::kGrid);
      painter.drawRect(square.adjusted(0, 0, -1, -1));
    }
    if (episode == shown_) {
      painter.setPen(QPen(theme::kInk, 2));
      painter.drawRect(square);
    }
  }
}

void EpisodeStrip::mousePressEvent(QMouseEvent* event) {
  if (const std::optional<std::uint64_t> episode = episodeAt(event->pos())) {
    Q_EMIT clicked(*episode);
  }
}

QString EpisodeStrip::toolTipOf(std::uint64_t episode) const {
  const QString name = "episode " + QString::number(episode);
  const std::optional<int> row = episodes_->rowOfEpisode(episode);
  if (!row) {
    return name + ": not finished";
  }
  const EpisodeRow& outcome = episodes_->row(*row);
  const auto words = [](bool success) { return success ? "succeeds" : "fails"; };
  return name + ": reference " + words(outcome.reference.success) + ", engine " + words(outcome.engine.success);
}

bool EpisodeStrip::event(QEvent* event) {
  if (event->type() == QEvent::ToolTip) {
    const auto* const help = static_cast<QHelpEvent*>(event);
    if (const std::optional<std::uint64_t> episode = episodeAt(help->pos())) {
      QToolTip::showText(help->globalPos(), toolTipOf(*episode), this);
      return true;
    }
    QToolTip::hideText();
  }
  return QWidget::event(event);
}

}  // namespace pusht_rviz
