// SPDX-License-Identifier: BSD-3-Clause
#include "node_row.hpp"

#include <QColor>
#include <QHBoxLayout>

#include "theme.hpp"

namespace pusht_rviz {
namespace {

struct Look {
  const char* sign;
  const char* word;
  QColor color;
};

Look lookOf(Presence presence, bool busy) {
  switch (presence) {
    case Presence::kAlive:
      return busy ? Look{"▶", "busy", theme::kReference} : Look{"●", "alive", theme::kGood};
    case Presence::kSilent:
      return {"…", "gives no answer", theme::kEngine};
    case Presence::kLost:
      return {"✕", "lost", theme::kBad};
    case Presence::kWaiting:
      break;
  }
  return {"○", "not there yet", theme::kAxis};
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
    states_.at(node).label = label;
  }
}

void NodeRow::setDescription(Node node, const pusht_msgs::DescribeResponse& description) {
  State& state = states_.at(node);
  state.title = QString::fromStdString(description.title.empty() ? description.name : description.title);
  state.fault = description.success != 0 ? "" : QString::fromStdString(description.message);
}

void NodeRow::show(bool busy, bool replay) {
  for (std::size_t node = 0; node < kNodes; ++node) {
    const State& state = states_.at(node);
    const bool failed = state.presence == Presence::kAlive && !state.fault.isEmpty();
    const Look look = failed ? Look{"!", "failed at its start", theme::kBad} : lookOf(state.presence, busy);
    const QString name = node == kEvaluator && replay ? "player" : kNodeNames.at(node);
    state.label->setText("<span style='color:" + look.color.name() + "'>" + QString::fromUtf8(look.sign) +
                         "</span>&nbsp;" + name);
    state.label->setToolTip(name + ": " + look.word + (failed ? ": " + state.fault : "") +
                            (state.title.isEmpty() ? "" : " (" + state.title + ")"));
    state.label->setVisible(!replay || node == kEvaluator);
  }
}

QStringList NodeRow::complaints() const {
  QStringList lines;
  for (std::size_t node = 0; node < kNodes; ++node) {
    const State& state = states_.at(node);
    const QString name = QString(kNodeNames.at(node)) + ": ";
    if (state.presence == Presence::kLost || state.presence == Presence::kSilent) {
      lines << name + lookOf(state.presence, false).word;
    } else if (!state.fault.isEmpty()) {
      lines << name + state.fault;
    }
  }
  return lines;
}

}  // namespace pusht_rviz
