// SPDX-License-Identifier: BSD-3-Clause
#include "replay_controls.hpp"

#include <QPainter>
#include <QSignalBlocker>
#include <QStyle>
#include <QVBoxLayout>
#include <algorithm>
#include <utility>

#include "pusht_task/constants.hpp"
#include "theme.hpp"

namespace pusht_rviz {

MarkedSlider::MarkedSlider(QWidget* parent) : QSlider(Qt::Horizontal, parent) {}

void MarkedSlider::setMarks(std::vector<Mark> marks) {
  marks_ = std::move(marks);
  update();
}

void MarkedSlider::paintEvent(QPaintEvent* event) {
  QSlider::paintEvent(event);
  QPainter painter(this);
  constexpr int kHandle = 12;  // [px] as in the style sheet
  for (const Mark& mark : marks_) {
    const int at = QStyle::sliderPositionFromValue(minimum(), maximum(), mark.value, width() - kHandle) + kHandle / 2;
    painter.fillRect(at - 1, 0, 3, height(), mark.color);
  }
}

ReplayControls::ReplayControls(QWidget* parent)
    : QWidget(parent), scrubber_(new MarkedSlider(this)), position_(new QLabel(this)) {
  scrubber_->setObjectName("scrubber");
  scrubber_->setToolTip(
      "control steps of the episode that is shown; ticks: where the replay (red) and the engine (yellow) leave the "
      "bound around the reference");
  scrubber_->setRange(0, 0);
  position_->setObjectName("position");
  position_->setProperty("dim", true);
  auto* const all = new QVBoxLayout(this);
  all->setContentsMargins(0, 0, 0, 0);
  all->setSpacing(4);
  all->addWidget(scrubber_);
  all->addWidget(position_);
  connect(scrubber_, &QSlider::valueChanged, this,
          [this](int step) { Q_EMIT stepChosen(static_cast<std::uint32_t>(step)); });
}

void ReplayControls::show(std::uint64_t episode, std::uint32_t step, const EpisodeRow* row) {
  const std::uint32_t steps = std::max(row == nullptr ? 0 : row->steps, step);
  if (!scrubber_->isSliderDown()) {
    const QSignalBlocker quiet(scrubber_);
    scrubber_->setRange(0, static_cast<int>(steps));
    scrubber_->setValue(static_cast<int>(step));
  }
  std::vector<MarkedSlider::Mark> marks;
  if (row != nullptr) {
    for (const auto& [at, color] :
         {std::pair(row->closed_parting_step, theme::kEngine), std::pair(row->parting_step, theme::kReplay)}) {
      if (at > 0) {
        marks.push_back({static_cast<int>(at), color});
      }
    }
  }
  scrubber_->setMarks(std::move(marks));
  position_->setText("episode " + QString::number(episode) + QString::fromUtf8(" · ") +
                     QString::number(pusht::kControlStep * step, 'f', 1) + " / " +
                     QString::number(pusht::kControlStep * steps, 'f', 1) + " s");
}

}  // namespace pusht_rviz
