// SPDX-License-Identifier: BSD-3-Clause
#include "simulator_property.hpp"

#include <algorithm>
#include <utility>

#include "nodes.hpp"
#include "theme.hpp"

namespace pusht_rviz {
namespace {

constexpr const char* kWaiting = "waiting for the node";

/// Whether the parameters have the same names and descriptors in the same order, whatever their values.
bool sameParameters(const pusht_msgs::DescribeResponse& one, const pusht_msgs::DescribeResponse& other) {
  const auto same_name = [](const auto& a, const auto& b) { return a.name == b.name; };
  return one.parameter_descriptors == other.parameter_descriptors &&
         std::equal(one.parameters.begin(), one.parameters.end(), other.parameters.begin(), other.parameters.end(),
                    same_name);
}

QString titleOf(const pusht_msgs::DescribeResponse& node) {
  if (node.success == 0) {
    return QString::fromStdString(node.message);
  }
  return QString::fromStdString(node.title.empty() ? node.name : node.title);
}

}  // namespace

SimulatorProperty::SimulatorProperty(const QString& node, rviz::Property* parent) : ParameterGroup(node, parent) {
  note(kWaiting);
  connect(this, &rviz::Property::changed, this, [this] {
    if (getValue().toString().toStdString() != kind_) {
      choose(getValue().toString().toStdString());
    }
  });
}

void SimulatorProperty::note(const QString& text) {
  note_ = text;
  setReadOnly(!text.isEmpty());
  setDescription(text.isEmpty() ? "kind of simulator in the next run" : text);
}

void SimulatorProperty::setRequest(const std::string& kind, const std::vector<pusht_msgs::Parameter>& parameters) {
  request_kind_ = kind;
  request_parameters_ = parameters;
  if (std::exchange(known_, false)) {
    pending_ = false;
    kind_.clear();
    setNode(pusht_msgs::DescribeResponse(node_));
  }
}

void SimulatorProperty::setNode(const pusht_msgs::DescribeResponse& description) {
  const bool same_kinds = known_ && description.kinds == node_.kinds;
  const bool same_parameters = same_kinds && kind_ == description.name && sameParameters(description, node_);
  node_ = description;
  known_ = true;
  if (description.kinds.empty()) {  // it stays the kind that it is
    note(titleOf(description));
    if (!same_parameters) {
      finish(description.name, description);
    }
  } else if (!same_kinds || kind_.empty()) {
    offerKinds();
  } else if (pending_) {
    Q_EMIT kindNeeded(QString::fromStdString(kind_));  // an answer was lost
  }
}

void SimulatorProperty::offerKinds() {
  const auto has = [&](const std::string& kind) {
    return std::find(node_.kinds.begin(), node_.kinds.end(), kind) != node_.kinds.end();
  };
  clearOptions();
  for (const std::string& kind : node_.kinds) {
    addOptionStd(kind);
  }
  note("");
  choose(has(request_kind_) ? request_kind_ : has(node_.name) ? node_.name : node_.kinds.front());
}

QString SimulatorProperty::waitsFor() const {
  if (!pending_) {
    return "";
  }
  return getName() + ": " +
         (refusal_.empty() ? "waiting for the node to describe " + QString::fromStdString(kind_)
                           : QString::fromStdString(refusal_));
}

void SimulatorProperty::choose(const std::string& kind) {
  pending_ = true;
  refusal_.clear();
  kind_ = kind;
  setStringStd(kind);
  clear();
  Q_EMIT edited();
  Q_EMIT kindNeeded(QString::fromStdString(kind));
}

void SimulatorProperty::setKind(const QString& kind, const pusht_msgs::DescribeResponse& description) {
  if (kind.isEmpty() || kind.toStdString() != kind_) {
    return;  // another kind was chosen since
  }
  setDescription(titleOf(description));
  if (description.success == 0) {
    refusal_ = description.message;
    Q_EMIT edited();
    return;
  }
  pending_ = false;
  finish(kind_, description);
}

/// The parameters at first: those that the evaluator asks for; where it leaves the kind open, on top of what a node of
/// that kind has.
void SimulatorProperty::finish(const std::string& kind, const pusht_msgs::DescribeResponse& description) {
  kind_ = kind;
  setStringStd(kind);
  std::vector<pusht_msgs::Parameter> chosen;
  if (kind == request_kind_) {
    chosen = request_parameters_;
  } else if (request_kind_.empty() && kind == node_.name) {
    chosen = node_.parameters;
    chosen.insert(chosen.end(), request_parameters_.begin(), request_parameters_.end());
  }
  build(description, chosen);
}

QVariant SimulatorProperty::getViewData(int column, int role) const {
  if (role == Qt::ToolTipRole) {
    return getDescription();
  }
  if (column == 1 && role == Qt::DisplayRole && !note_.isEmpty()) {
    return note_;
  }
  if (role == Qt::ForegroundRole && (column == 0 || !note_.isEmpty())) {
    return column == 1 ? theme::kDim : getName() == kNodeNames[kReference] ? theme::kReference : theme::kEngine;
  }
  return ParameterGroup::getViewData(column, role);
}

}  // namespace pusht_rviz
