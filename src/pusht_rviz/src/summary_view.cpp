// SPDX-License-Identifier: BSD-3-Clause
#include "summary_view.hpp"

#include <QGridLayout>
#include <QVBoxLayout>
#include <QVariant>
#include <string>

#include "texts.hpp"
#include "theme.hpp"

namespace pusht_rviz {
namespace {

QLabel* label(const QString& text, const QColor& color) {
  auto* const made = new QLabel(text);
  made->setStyleSheet("color: " + color.name());
  return made;
}

QLabel* figure(QWidget* parent, const char* name) {
  auto* const made = new QLabel(QString::fromUtf8(kDash), parent);
  made->setObjectName(name);
  made->setTextInteractionFlags(Qt::TextSelectableByMouse);
  return made;
}

}  // namespace

SummaryView::SummaryView(QWidget* strip, QWidget* parent)
    : QWidget(parent),
      headline_(new QLabel(this)),
      caveat_(new QLabel(this)),
      reference_(figure(this, "reference_success")),
      engine_(figure(this, "engine_success")),
      transfer_(figure(this, "transfer")),
      pairs_(figure(this, "pairs")),
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
  line(label("transfer", theme::kInk), transfer_,
       "engine success over reference success: the share of the skill that is kept");
  constexpr const char* kMeanTip =
      "mean divergence of the replay's tee from the reference's, in position and in angle; (!): not shown to be less "
      "than that of a tee that never moves; (?): too few episodes to say";
  line(label("mean divergence", theme::kReplay), position_, kMeanTip);
  line(label("", theme::kReplay), angle_, kMeanTip);
  reference_->setProperty("head", true);
  engine_->setProperty("head", true);
  transfer_->setProperty("head", true);

  headline_->setObjectName("headline");
  headline_->setWordWrap(true);
  headline_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  headline_->hide();
  caveat_->setObjectName("caveat");
  caveat_->setProperty("dim", true);
  caveat_->setWordWrap(true);
  caveat_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  caveat_->hide();
  pairs_->setProperty("dim", true);
  pairs_->setToolTip(
      "the same episodes in both worlds; a square: reference on the left, engine on the right, filled "
      "where the policy succeeds");

  auto* const all = new QVBoxLayout(this);
  all->setContentsMargins(4, 4, 4, 2);
  all->setSpacing(4);
  all->addWidget(caveat_);  // to be known before the answer
  all->addWidget(headline_);
  all->addLayout(rates);
  all->addWidget(strip);
  all->addWidget(pairs_);
  show(pusht_msgs::Summary());
}

void SummaryView::show(const pusht_msgs::Summary& summary) {
  headline_->setText(QString::fromStdString(summary.headline));
  headline_->setVisible(!summary.headline.empty());
  caveat_->setText(QString::fromStdString(summary.caveat));
  caveat_->setVisible(!summary.caveat.empty());
  reference_->setText(QString::fromStdString(orDash(summary.reference.text)));
  engine_->setText(QString::fromStdString(orDash(summary.engine.text)));
  transfer_->setText(QString::fromStdString(orDash(summary.transfer_text)));
  pairs_->setText(QString::fromStdString(pairsText(summary)));
  position_->setText(QString::fromStdString(meanText(summary, "mean_pos_divergence")));
  angle_->setText(QString::fromStdString(meanText(summary, "mean_ang_divergence")));
}

}  // namespace pusht_rviz
