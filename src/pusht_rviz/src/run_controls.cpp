// SPDX-License-Identifier: BSD-3-Clause
#include "run_controls.hpp"

#include <QAbstractItemView>
#include <QHBoxLayout>
#include <QSignalBlocker>
#include <QStringList>
#include <QVBoxLayout>
#include <algorithm>
#include <array>

#include "pusht_task/constants.hpp"
#include "texts.hpp"
#include "theme.hpp"

namespace pusht_rviz {
namespace {

constexpr std::array kRates = {2.0, 10.0, 25.0, 50.0, 100.0, 0.0};  // [control steps/s]; the last: full speed
constexpr double kRealTime = 1.0 / pusht::kControlStep;             // [control steps/s]
constexpr const char* kStartTip = "begins the run that `Next run` describes";

QString paceLabel(double rate) {
  const QString text = QString::fromStdString(paceText(rate));
  return rate == kRealTime ? text + ", real time" : text;
}

QPushButton* largeButton(QWidget* parent, const char* name, const QString& text, theme::Shape shape, const char* tip) {
  auto* const button = new QPushButton(theme::icon(shape), text, parent);
  button->setObjectName(name);
  button->setToolTip(tip);
  button->setProperty("large", true);
  button->setMinimumWidth(10);
  button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  return button;
}

/// What the run does, in words.
QString stateText(const Situation& situation, const pusht_msgs::Progress& progress) {
  if (situation.cancelling) {
    return "ending";
  }
  if (situation.paused) {
    return "paused";
  }
  if (!progress.waiting_for.empty()) {
    return "waits for " + QString::fromStdString(progress.waiting_for);
  }
  if (situation.busy && !situation.replay) {
    const QString left = QString::fromStdString(timeLeftText(progress.seconds_left));
    return left.isEmpty() ? "runs" : left;
  }
  return situation.asked ? "begins" : "";
}

}  // namespace

RunControls::RunControls(QWidget* parent)
    : QWidget(parent),
      start_(largeButton(this, "start", "Start", theme::Shape::kStart, kStartTip)),
      pause_(largeButton(this, "pause", "Pause", theme::Shape::kPause, "")),
      step_(largeButton(this, "step", "Step", theme::Shape::kStep, "one control step of 0.1 s, while paused")),
      cancel_(largeButton(this, "cancel", "Cancel", theme::Shape::kStop, "ends the run; finished episodes are kept")),
      rate_(new QComboBox(this)),
      progress_(new QProgressBar(this)),
      play_icon_(theme::icon(theme::Shape::kPlay)),
      pause_icon_(theme::icon(theme::Shape::kPause)) {
  rate_->setObjectName("rate");
  rate_->setToolTip("control steps per second; a control step is 0.1 s");
  for (const double rate : kRates) {
    rate_->addItem(paceLabel(rate), rate);
  }
  progress_->setObjectName("progress");
  progress_->setMinimumWidth(100);

  auto* const all = new QVBoxLayout(this);
  all->setContentsMargins(0, 0, 0, 0);
  all->setSpacing(6);
  auto* const buttons = new QHBoxLayout;
  buttons->setSpacing(4);
  for (QPushButton* const button : {start_, pause_, step_, cancel_}) {
    buttons->addWidget(button, 1);
  }
  all->addLayout(buttons);
  auto* const pace = new QHBoxLayout;
  pace->setSpacing(4);
  pace->addWidget(rate_);
  pace->addWidget(progress_, 1);
  all->addLayout(pace);

  connect(start_, &QPushButton::clicked, this, &RunControls::startPressed);
  connect(pause_, &QPushButton::clicked, this, &RunControls::pausePressed);
  connect(step_, &QPushButton::clicked, this, &RunControls::stepPressed);
  connect(cancel_, &QPushButton::clicked, this, &RunControls::cancelPressed);
  connect(rate_, QOverload<int>::of(&QComboBox::activated), this,
          [this] { Q_EMIT rateChosen(rate_->currentData().toDouble()); });
}

void RunControls::show(const Situation& situation, const pusht_msgs::Progress& progress) {
  showButtons(situation);
  showProgress(situation, progress);
}

void RunControls::showButtons(const Situation& situation) {
  const Buttons buttons = buttonsFor(situation);
  start_->setVisible(!situation.replay);
  cancel_->setVisible(!situation.replay);
  start_->setEnabled(buttons.start);
  start_->setToolTip(buttons.start ? kStartTip : QString::fromStdString(buttons.why_not));
  pause_->setEnabled(buttons.pause);
  pause_->setText(buttons.resumes ? (situation.replay ? "Play" : "Resume") : "Pause");
  pause_->setIcon(buttons.resumes ? play_icon_ : pause_icon_);
  pause_->setToolTip(buttons.resumes ? "goes on" : "takes no further control step");
  step_->setEnabled(buttons.step);
  cancel_->setEnabled(buttons.cancel);
  rate_->setEnabled(buttons.rate);
}

void RunControls::showProgress(const Situation& situation, const pusht_msgs::Progress& progress) {
  const int episodes = static_cast<int>(progress.episodes);
  const int finished = static_cast<int>(progress.episodes_finished);
  progress_->setRange(0, std::max(1, episodes));
  progress_->setValue(finished);
  QStringList words;
  if (episodes > 0) {
    words << QString::number(finished) + " / " + QString::number(episodes);
  }
  if (const QString state = stateText(situation, progress); !state.isEmpty()) {
    words << state;
  }
  progress_->setFormat(words.isEmpty() ? "no run yet" : words.join(QString::fromUtf8(" · ")));
}

void RunControls::showRate(double rate) {
  const QSignalBlocker quiet(rate_);
  if (rate_->findData(rate) < 0) {
    rate_->insertItem(0, paceLabel(rate), rate);
  }
  if (rate_->currentIndex() != rate_->findData(rate) && !rate_->view()->isVisible()) {
    rate_->setCurrentIndex(rate_->findData(rate));
  }
}

}  // namespace pusht_rviz
