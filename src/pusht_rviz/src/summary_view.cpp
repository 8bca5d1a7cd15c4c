// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/summary_view.hpp"

#include <QGridLayout>
#include <QVBoxLayout>
#include <QVariant>
#include <string>

#include "pusht_rviz/numbers.hpp"
#include "pusht_rviz/theme.hpp"

namespace pusht_rviz {
namespace {

QLabel* label(const QString& text, const QColor& colour) {
  auto* const made = new QLabel(text);
  made->setStyleSheet("color: " + colour.name());
  return made;
}

QLabel* figure(QWidget* parent, const char* name) {
  auto* const made = new QLabel(QString::fromUtf8(kDash), parent);
  made->setObjectName(name);
  made->setTextInteractionFlags(Qt::TextSelectableByMouse);
  return made;
}

}  // namespace

SummaryView::SummaryView(QWidget* parent)
    : QWidget(parent),
      reference_(figure(this, "reference_success")),
      engine_(figure(this, "engine_success")),
      transfer_(figure(this, "transfer")),
      both_(figure(this, "both")),
      only_reference_(figure(this, "only_reference")),
      only_engine_(figure(this, "only_engine")),
      neither_(figure(this, "neither")),
      position_(figure(this, "mean_position")),
      angle_(figure(this, "mean_angle")) {
  auto* const rates = new QGridLayout;
  rates->setHorizontalSpacing(10);
  rates->setVerticalSpacing(2);
  rates->setColumnStretch(1, 1);
  int row = 0;
  const auto line = [&](QLabel* head, QLabel* value, const char* tip) {
    head->setToolTip(tip);
    value->setToolTip(tip);
    rates->addWidget(head, row, 0);
    rates->addWidget(value, row++, 1);
  };
  constexpr const char* kRateTip = "episodes in which the policy succeeds, closed loop; in brackets 95 % intervals";
  line(label("reference solves", theme::kReference), reference_, kRateTip);
  line(label("engine solves", theme::kEngine), engine_, kRateTip);
  line(label("transfer", theme::kBright), transfer_,
       "engine success over reference success: the share of the skill that is kept");
  constexpr const char* kMeanTip =
      "mean divergence of the replay's tee from the reference's, in position and in angle; (!): not shown to be less "
      "than that of a tee that never moves; (?): too few episodes to say";
  line(label("mean divergence", theme::kReplay), position_, kMeanTip);
  line(label("", theme::kReplay), angle_, kMeanTip);
  reference_->setProperty("head", true);
  engine_->setProperty("head", true);
  transfer_->setProperty("head", true);

  // The same episodes, in both worlds.
  auto* const pairs = new QGridLayout;
  pairs->setHorizontalSpacing(10);
  pairs->setVerticalSpacing(0);
  const auto count = [&](QLabel* value, const char* name, int column) {
    auto* const head = new QLabel(name);
    head->setProperty("dim", true);
    head->setAlignment(Qt::AlignCenter);
    value->setAlignment(Qt::AlignCenter);
    value->setProperty("head", true);
    pairs->addWidget(value, 0, column);
    pairs->addWidget(head, 1, column);
    pairs->setColumnStretch(column, 1);
  };
  count(both_, "both solve", 0);
  count(only_reference_, "only reference", 1);
  count(only_engine_, "only engine", 2);
  count(neither_, "neither", 3);

  auto* const all = new QVBoxLayout(this);
  all->setContentsMargins(4, 4, 4, 2);
  all->setSpacing(4);
  all->addLayout(rates);
  all->addLayout(pairs);
}

void SummaryView::show(const pusht_msgs::Summary& summary) {
  const auto count = [&](std::uint32_t episodes) {
    return summary.episodes_finished == 0 ? QString::fromUtf8(kDash) : QString::number(episodes);
  };
  reference_->setText(QString::fromStdString(rateText(summary.reference)));
  engine_->setText(QString::fromStdString(rateText(summary.engine)));
  transfer_->setText(QString::fromStdString(transferText(summary)));
  both_->setText(count(summary.both_succeed));
  only_reference_->setText(count(summary.only_reference_succeeds));
  only_engine_->setText(count(summary.only_engine_succeeds));
  neither_->setText(count(summary.neither_succeeds));
  position_->setText(QString::fromStdString(meanText(summary, "mean_pos_divergence")));
  angle_->setText(QString::fromStdString(meanText(summary, "mean_ang_divergence")));
}

void SummaryView::clear() { show(pusht_msgs::Summary()); }

}  // namespace pusht_rviz
