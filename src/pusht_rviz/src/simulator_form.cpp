// SPDX-License-Identifier: BSD-3-Clause
#include "simulator_form.hpp"

#include <QSignalBlocker>
#include <QVBoxLayout>
#include <algorithm>

#include "quiet_wheel.hpp"

namespace pusht_rviz {
namespace {

constexpr const char* kWaiting = "waiting for the node";

QString toQt(const std::string& text) { return QString::fromStdString(text); }

/// Whether the parameters have the same names and descriptors in the same order, whatever their values.
bool sameParameters(const pusht_msgs::DescribeResponse& one, const pusht_msgs::DescribeResponse& other) {
  const auto same_name = [](const auto& a, const auto& b) { return a.name == b.name; };
  return one.parameter_descriptors == other.parameter_descriptors &&
         std::equal(one.parameters.begin(), one.parameters.end(), other.parameters.begin(), other.parameters.end(),
                    same_name);
}

QString titleOf(const pusht_msgs::DescribeResponse& node) {
  if (node.success == 0) {
    return toQt(node.message);
  }
  return toQt(node.title.empty() ? node.name : node.title);
}

}  // namespace

SimulatorForm::SimulatorForm(const QString& node, QWidget* parent)
    : QGroupBox(node, parent),
      name_(node),
      title_(new QLabel(kWaiting, this)),
      kinds_(new QComboBox(this)),
      parameters_(new ParameterForm(node + ".", this)) {
  title_->setObjectName(node + ".title");
  title_->setWordWrap(true);
  kinds_->setObjectName(node);
  kinds_->setToolTip("kind of simulator in the next run");
  kinds_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  kinds_->hide();
  quietWheel(kinds_);
  connect(kinds_, QOverload<int>::of(&QComboBox::activated), this, [this] { choose(kinds_->currentText()); });
  connect(parameters_, &ParameterForm::changed, this, &SimulatorForm::changed);
  auto* const all = new QVBoxLayout(this);
  all->setContentsMargins(8, 6, 8, 6);
  all->setSpacing(4);
  all->addWidget(kinds_);
  all->addWidget(title_);
  all->addWidget(parameters_);
}

void SimulatorForm::setRequest(const std::string& kind, const std::vector<pusht_msgs::Parameter>& parameters) {
  request_kind_ = kind;
  request_parameters_ = parameters;
  if (known_) {
    const pusht_msgs::DescribeResponse node = node_;
    forget();
    setNode(node);
  }
}

void SimulatorForm::setNode(const pusht_msgs::DescribeResponse& description) {
  const bool same_kinds = known_ && description.kinds == node_.kinds;
  const bool same_parameters = same_kinds && kind_ == description.name && sameParameters(description, node_);
  node_ = description;
  known_ = true;
  title_->setText(titleOf(description));
  if (description.kinds.empty()) {  // it stays the kind that it is
    kinds_->hide();
    title_->show();
    if (!same_parameters) {
      build(description.name, description);
    }
  } else if (!same_kinds || kind_.empty()) {
    offerKinds();
  } else if (pending_) {
    Q_EMIT kindNeeded(toQt(kind_));  // an answer was lost
  }
}

void SimulatorForm::offerKinds() {
  const auto has = [&](const std::string& kind) {
    return std::find(node_.kinds.begin(), node_.kinds.end(), kind) != node_.kinds.end();
  };
  {
    const QSignalBlocker quiet(kinds_);
    kinds_->clear();
    for (const std::string& kind : node_.kinds) {
      kinds_->addItem(toQt(kind));
    }
    kinds_->setCurrentText(toQt(has(request_kind_) ? request_kind_
                                : has(node_.name)  ? node_.name
                                                   : node_.kinds.front()));
  }
  kinds_->show();
  title_->hide();
  choose(kinds_->currentText());
}

QString SimulatorForm::waitsFor() const {
  return pending_ ? name_ + ": waiting for the node to describe " + toQt(kind_) : "";
}

void SimulatorForm::choose(const QString& kind) {
  pending_ = true;
  kind_ = kind.toStdString();
  parameters_->build({});
  Q_EMIT kindNeeded(kind);
}

void SimulatorForm::setKind(const QString& kind, const pusht_msgs::DescribeResponse& description) {
  if (kind.isEmpty() || kind.toStdString() != kind_) {
    return;  // another kind was chosen since
  }
  if (description.success == 0) {
    title_->setText(toQt(description.message));
    title_->show();
    return;
  }
  title_->hide();
  pending_ = false;
  kinds_->setToolTip(toQt(description.title));
  build(kind_, description);
}

/// Parameters of a kind that are not at their defaults at first: those that the evaluator asks for; where it leaves the
/// kind open, on top of what a node of that kind has.
std::vector<pusht_msgs::Parameter> SimulatorForm::firstChoice(const std::string& kind) const {
  if (kind == request_kind_) {
    return request_parameters_;
  }
  if (!request_kind_.empty() || kind != node_.name) {
    return {};
  }
  std::vector<pusht_msgs::Parameter> chosen = node_.parameters;
  chosen.insert(chosen.end(), request_parameters_.begin(), request_parameters_.end());
  return chosen;
}

void SimulatorForm::forget() {
  known_ = pending_ = false;
  node_ = {};
  kinds_->hide();
  title_->setText(kWaiting);
  title_->show();
  kind_.clear();
  parameters_->build({});
}

void SimulatorForm::build(const std::string& kind, const pusht_msgs::DescribeResponse& description) {
  kind_ = kind;
  parameters_->build(ParameterDraft(description, firstChoice(kind)));
}

}  // namespace pusht_rviz
