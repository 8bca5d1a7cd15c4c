// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/simulator_form.hpp"

#include <QCheckBox>
#include <QHBoxLayout>
#include <QLayoutItem>
#include <QLineEdit>
#include <QSignalBlocker>
#include <QStringList>
#include <QVBoxLayout>
#include <algorithm>
#include <cstddef>
#include <memory>

#include "pusht_rviz/quiet_wheel.hpp"
#include "pusht_rviz/theme.hpp"

namespace pusht_rviz {
namespace {

constexpr int kEditorWidth = 84;  // [px] at least

QString shown(const std::string& text) { return QString::fromStdString(text); }

/// What a parameter is, for people.
QString described(const pusht_msgs::ParameterDescriptor& parameter) {
  QStringList lines;
  for (const std::string& line : {parameter.meaning, rangeText(parameter),
                                  parameter.default_value.empty() ? "" : "default: " + parameter.default_value}) {
    if (!line.empty()) {
      lines << shown(line);
    }
  }
  return lines.join("\n");
}

/// Whether the parameters have the same names and defaults in the same order, whatever their values.
bool sameParameters(const pusht_msgs::DescribeResponse& one, const pusht_msgs::DescribeResponse& other) {
  const auto same_name = [](const auto& a, const auto& b) { return a.name == b.name; };
  return one.parameter_descriptors == other.parameter_descriptors &&
         std::equal(one.parameters.begin(), one.parameters.end(), other.parameters.begin(), other.parameters.end(),
                    same_name);
}

}  // namespace

SimulatorForm::SimulatorForm(const QString& role, QWidget* parent)
    : QGroupBox(role, parent),
      role_(role),
      title_(new QLabel("waiting for the node", this)),
      kinds_(new QComboBox(this)),
      parameters_(new QWidget(this)) {
  title_->setObjectName(role + ".title");
  title_->setWordWrap(true);
  kinds_->setObjectName(role);
  kinds_->setToolTip("kind of simulator that plays this role in the next run");
  kinds_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  kinds_->hide();
  quietWheel(kinds_);
  connect(kinds_, QOverload<int>::of(&QComboBox::activated), this, [this] { choose(kinds_->currentText()); });
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
  const bool same_parameters = same_kinds && draft_.kind == description.name && sameParameters(description, node_);
  node_ = description;
  known_ = true;
  title_->setText(shown(description.success == 0    ? description.message
                        : description.title.empty() ? description.name
                                                    : description.title));
  if (description.kinds.empty()) {
    kinds_->hide();
    title_->show();
    if (!same_parameters) {  // else the choice stands, whatever the node became since
      build(draftOf(description.name, description, firstChoice(description.name)));
    }
    return;
  }
  if (same_kinds && !draft_.kind.empty()) {  // the choice stands, whatever the node became since
    if (pending_) {
      Q_EMIT kindNeeded(shown(draft_.kind));  // an answer was lost
    }
    return;
  }
  const auto has = [&](const std::string& kind) {
    return std::find(description.kinds.begin(), description.kinds.end(), kind) != description.kinds.end();
  };
  {
    const QSignalBlocker quiet(kinds_);
    kinds_->clear();
    for (const std::string& kind : description.kinds) {
      kinds_->addItem(shown(kind));
    }
    kinds_->setCurrentText(shown(has(request_kind_)      ? request_kind_
                                 : has(description.name) ? description.name
                                                         : description.kinds.front()));
  }
  kinds_->show();
  title_->hide();
  choose(kinds_->currentText());
}

QString SimulatorForm::waitsFor() const {
  return pending_ ? role_ + ": waiting for the node to describe " + shown(draft_.kind) : "";
}

void SimulatorForm::choose(const QString& kind) {
  pending_ = true;
  build({kind.toStdString(), {}});  // until the answer is there
  Q_EMIT kindNeeded(kind);
}

void SimulatorForm::setKind(const QString& kind, const pusht_msgs::DescribeResponse& description) {
  if (kind.isEmpty() || kind.toStdString() != draft_.kind) {
    return;  // another one was chosen since
  }
  if (description.success == 0) {
    title_->setText(shown(description.message));
    title_->show();
    return;
  }
  title_->hide();
  pending_ = false;
  kinds_->setToolTip(shown(description.title));
  build(draftOf(kind.toStdString(), description, firstChoice(kind.toStdString())));
}

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
  title_->setText("waiting for the node");
  title_->show();
  build({});
}

void SimulatorForm::build(const SimulatorDraft& draft) {
  draft_ = draft;
  rows_.clear();
  auto* const fresh = new QWidget(this);
  auto* const grid = new QGridLayout(fresh);
  grid->setContentsMargins(0, 0, 0, 0);
  grid->setHorizontalSpacing(6);
  grid->setVerticalSpacing(3);
  grid->setColumnStretch(0, 3);
  grid->setColumnStretch(1, 2);
  const std::unique_ptr<QLayoutItem> place(layout()->replaceWidget(parameters_, fresh));  // ours from now on
  parameters_->hide();
  parameters_->deleteLater();  // perhaps one of its widgets has just called us
  parameters_ = fresh;
  for (std::size_t i = 0; i < draft_.settings.size(); ++i) {
    addRow(draft_.settings[i], static_cast<int>(i));
    show(i);
  }
  fresh->show();
  Q_EMIT changed();
}

void SimulatorForm::addRow(const Setting& setting, int line) {
  const pusht_msgs::ParameterDescriptor& parameter = setting.parameter;
  const QString object_name = role_ + "." + shown(parameter.name);
  const std::size_t place = rows_.size();
  Row row;
  row.name = new QLabel(parameters_);
  row.name->setWordWrap(true);
  row.refusal = new QLabel(parameters_);
  row.refusal->setObjectName(object_name + ".refusal");
  row.refusal->setProperty("refusal", true);
  row.refusal->setWordWrap(true);
  row.refusal->hide();
  row.reset = new QToolButton(parameters_);
  row.reset->setObjectName(object_name + ".reset");
  row.reset->setText(QString::fromUtf8("↺"));
  if (parameter.type == "boolean") {
    auto* const box = new QCheckBox(parameters_);
    row.show = [box](const QString& text) { box->setChecked(text == "true"); };
    row.editor = box;
    connect(box, &QCheckBox::toggled, this, [this, place](bool on) { edit(place, on ? "true" : "false"); });
  } else if (!parameter.words.empty()) {
    auto* const combo = new QComboBox(parameters_);
    combo->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
    quietWheel(combo);
    for (const std::string& word : parameter.words) {
      combo->addItem(shown(word));
    }
    row.show = [combo](const QString& text) { combo->setCurrentText(text); };
    row.editor = combo;
    connect(combo, &QComboBox::currentTextChanged, this, [this, place](const QString& text) { edit(place, text); });
  } else {
    auto* const field = new QLineEdit(parameters_);
    row.show = [field](const QString& text) { field->setText(text); };
    row.editor = field;
    connect(field, &QLineEdit::textChanged, this, [this, place](const QString& text) { edit(place, text.trimmed()); });
  }
  row.editor->setObjectName(object_name);
  row.editor->setMinimumWidth(kEditorWidth);
  auto* const unit = new QLabel(shown(parameter.unit), parameters_);
  unit->setProperty("dim", true);
  for (QWidget* const widget : std::initializer_list<QWidget*>{row.name, row.editor, unit}) {
    widget->setToolTip(described(parameter));
  }
  auto* const grid = static_cast<QGridLayout*>(parameters_->layout());
  grid->addWidget(row.name, 2 * line, 0);
  grid->addWidget(row.editor, 2 * line, 1);
  grid->addWidget(unit, 2 * line, 2);
  grid->addWidget(row.reset, 2 * line, 3);
  grid->addWidget(row.refusal, 2 * line + 1, 0, 1, 4);
  connect(row.reset, &QToolButton::clicked, this,
          [this, place] { rows_[place].show(shown(draft_.settings[place].base)); });
  rows_.push_back(row);
}

void SimulatorForm::edit(std::size_t row, const QString& text) {
  if (row >= rows_.size()) {
    return;
  }
  draft_.type(row, text.toStdString());
  mark(row);
  for (std::size_t other = 0; other < rows_.size(); ++other) {
    if (other != row) {
      show(other);
    }
  }
  Q_EMIT changed();
}

void SimulatorForm::show(std::size_t row) {
  {
    const QSignalBlocker quiet(rows_[row].editor);
    rows_[row].show(shown(draft_.settings[row].text));
  }
  mark(row);
}

void SimulatorForm::mark(std::size_t place) {
  const Setting& setting = draft_.settings[place];
  Row& row = rows_[place];
  const bool differs = setting.differs();
  const QString name = shown(setting.parameter.name).replace('_', QString::fromUtf8("_\u200b"));  // may wrap there
  row.name->setText(differs ? QString::fromUtf8("• <b>") + name.toHtmlEscaped() + "</b>" : name);
  row.reset->setEnabled(differs);
  row.reset->setToolTip("back to " + shown(setting.base));
  const std::string rule = differs ? refusalOf(setting.parameter, setting.text) : "";
  row.refusal->setText(shown(rule));
  row.refusal->setVisible(!rule.empty());
  theme::mark(row.editor, !rule.empty());
}

}  // namespace pusht_rviz
