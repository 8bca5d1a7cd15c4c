// SPDX-License-Identifier: BSD-3-Clause
#include "node_row.hpp"

#include <QColor>
#include <QHBoxLayout>

#include "theme.hpp"

namespace pusht_rviz {
namespace {

using pusht_msgs::NodeStatus;

struct Look {
  const char* sign;
  const char* word;
  QColor color;
};

Look lookOf(std::uint8_t presence, bool busy) {
  switch (presence) {
    case NodeStatus::ALIVE:
      return busy ? Look{"▶", "busy", theme::kReference} : Look{"●", "alive", theme::kGood};
    case NodeStatus::SILENT:
      return {"…", "gives no answer", theme::kEngine};
    case NodeStatus::LOST:
      return {"✕", "lost", theme::kBad};
    default:
      return {"○", "not there yet", theme::kAxis};
  }
}

}  // namespace

NodeRow::NodeRow(QWidget* parent) : QWidget(parent) {
  auto* const row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  row->setSpacing(4);
  for (std::size_t node = 0; node < kNodes; ++node) {
    auto* const label = new QLabel(this);
    label->setObjectName(QString("node.") + kNodeNames.at(node));
    label->setStyleSheet("font-size: " + QString::number(theme::px(12)) + "px");
    row->addWidget(label);
    if (node + 1 < kNodes) {
      row->addStretch(1);
    }
    labels_.at(node) = label;
  }
}

void NodeRow::show(bool busy, bool replay) {
  for (std::size_t node = 0; node < kNodes; ++node) {
    const NodeStatus& status = statuses_.at(node);
    const bool failed = status.presence == NodeStatus::ALIVE && !status.failure.empty();
    const Look look = failed ? Look{"!", "failed at its start", theme::kBad} : lookOf(status.presence, busy);
    const QString name = node == kEvaluator && replay ? "player" : kNodeNames.at(node);
    QLabel* const label = labels_.at(node);
    label->setText("<span style='color:" + look.color.name() + "'>" + QString::fromUtf8(look.sign) + "</span>&nbsp;" +
                   name);
    label->setToolTip(name + ": " + look.word + (failed ? ": " + QString::fromStdString(status.failure) : "") +
                      (status.title.empty() ? "" : " (" + QString::fromStdString(status.title) + ")"));
    label->setVisible(!replay || node == kEvaluator);
  }
}

QStringList NodeRow::complaints() const {
  QStringList lines;
  for (std::size_t node = 0; node < kNodes; ++node) {
    const NodeStatus& status = statuses_.at(node);
    const QString name = QString(kNodeNames.at(node)) + ": ";
    if (status.presence == NodeStatus::LOST || status.presence == NodeStatus::SILENT) {
      lines << name + lookOf(status.presence, false).word;
    } else if (!status.failure.empty()) {
      lines << name + QString::fromStdString(status.failure);
    }
  }
  return lines;
}

}  // namespace pusht_rviz
