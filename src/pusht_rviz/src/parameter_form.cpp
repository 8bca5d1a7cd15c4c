// SPDX-License-Identifier: BSD-3-Clause
#include "parameter_form.hpp"

#include <QCheckBox>
#include <QComboBox>
#include <QGridLayout>
#include <QLayoutItem>
#include <QLineEdit>
#include <QSignalBlocker>
#include <QStringList>
#include <QVBoxLayout>
#include <initializer_list>
#include <memory>
#include <utility>

#include "quiet_wheel.hpp"
#include "theme.hpp"

namespace pusht_rviz {
namespace {

constexpr int kEditorWidth = 84;  // [px] at least

QString shown(const std::string& text) { return QString::fromStdString(text); }

/// Tool tip: meaning, range and default.
QString described(const pusht_msgs::ParameterDescriptor& parameter) {
  QStringList lines;
  for (const std::string& line : {parameter.meaning, rangeOf(parameter),
                                  parameter.default_value.empty() ? "" : "default: " + parameter.default_value}) {
    if (!line.empty()) {
      lines << shown(line);
    }
  }
  return lines.join("\n");
}

}  // namespace

ParameterForm::ParameterForm(QString prefix, QWidget* parent)
    : QWidget(parent), prefix_(std::move(prefix)), grid_(new QWidget(this)) {
  auto* const all = new QVBoxLayout(this);
  all->setContentsMargins(0, 0, 0, 0);
  all->addWidget(grid_);
}

void ParameterForm::build(const ParameterDraft& draft) {
  draft_ = draft;
  rows_.clear();
  auto* const fresh = new QWidget(this);
  auto* const grid = new QGridLayout(fresh);
  grid->setContentsMargins(0, 0, 0, 0);
  grid->setHorizontalSpacing(6);
  grid->setVerticalSpacing(3);
  grid->setColumnStretch(0, 3);
  grid->setColumnStretch(1, 2);
  const std::unique_ptr<QLayoutItem> replaced(layout()->replaceWidget(grid_, fresh));  // it is ours to delete
  grid_->hide();
  grid_->deleteLater();  // not at once: the call may come from one of its controls
  grid_ = fresh;
  for (std::size_t i = 0; i < draft_.size(); ++i) {
    addRow(draft_[i]);
    show(i);
  }
  fresh->show();
  Q_EMIT changed();
}

void ParameterForm::addRow(const DraftedParameter& drafted) {
  const pusht_msgs::ParameterDescriptor& descriptor = drafted.descriptor;
  const QString object_name = prefix_ + shown(descriptor.name);
  const std::size_t index = rows_.size();
  Row row;
  row.name = new QLabel(grid_);
  row.name->setWordWrap(true);
  row.refusal = new QLabel(grid_);
  row.refusal->setObjectName(object_name + ".refusal");
  row.refusal->setProperty("refusal", true);
  row.refusal->setWordWrap(true);
  row.refusal->hide();
  row.reset = new QToolButton(grid_);
  row.reset->setObjectName(object_name + ".reset");
  row.reset->setText(QString::fromUtf8("↺"));
  connect(row.reset, &QToolButton::clicked, this, [this, index] { rows_[index].show(shown(draft_[index].base)); });
  makeEditor(row, descriptor);
  row.editor->setObjectName(object_name);
  row.editor->setMinimumWidth(kEditorWidth);
  auto* const unit = new QLabel(shown(descriptor.unit), grid_);
  unit->setProperty("dim", true);
  for (QWidget* const widget : std::initializer_list<QWidget*>{row.name, row.editor, unit}) {
    widget->setToolTip(described(descriptor));
  }
  auto* const grid = static_cast<QGridLayout*>(grid_->layout());
  const int line = 2 * static_cast<int>(index);
  grid->addWidget(row.name, line, 0);
  grid->addWidget(row.editor, line, 1);
  grid->addWidget(unit, line, 2);
  grid->addWidget(row.reset, line, 3);
  grid->addWidget(row.refusal, line + 1, 0, 1, 4);
  rows_.push_back(row);
}

void ParameterForm::makeEditor(Row& row, const pusht_msgs::ParameterDescriptor& descriptor) {
  const std::size_t index = rows_.size();
  if (descriptor.type == "boolean") {
    auto* const box = new QCheckBox(grid_);
    row.show = [box](const QString& text) { box->setChecked(text == "true"); };
    row.editor = box;
    connect(box, &QCheckBox::toggled, this, [this, index](bool on) { edit(index, on ? "true" : "false"); });
  } else if (!descriptor.words.empty()) {
    auto* const combo = new QComboBox(grid_);
    combo->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
    quietWheel(combo);
    for (const std::string& word : descriptor.words) {
      combo->addItem(shown(word));
    }
    row.show = [combo](const QString& text) { combo->setCurrentText(text); };
    row.editor = combo;
    connect(combo, &QComboBox::currentTextChanged, this, [this, index](const QString& text) { edit(index, text); });
  } else {
    auto* const field = new QLineEdit(grid_);
    row.show = [field](const QString& text) { field->setText(text); };
    row.editor = field;
    connect(field, &QLineEdit::textChanged, this, [this, index](const QString& text) { edit(index, text.trimmed()); });
  }
}

void ParameterForm::setText(const QString& name, const QString& text) {
  if (const std::optional<std::size_t> index = draft_.find(name.toStdString())) {
    type(*index, text);
    show(*index);
  }
}

void ParameterForm::edit(std::size_t index, const QString& text) {
  if (index < rows_.size()) {  // while rows are added there are signals, too
    type(index, text);
    Q_EMIT changed();
  }
}

/// Changes the draft, and shows what follows in the other rows.
void ParameterForm::type(std::size_t index, const QString& text) {
  draft_.type(index, text.toStdString());
  mark(index);
  for (std::size_t other = 0; other < rows_.size(); ++other) {
    if (other != index) {
      show(other);
    }
  }
}

void ParameterForm::show(std::size_t index) {
  {
    const QSignalBlocker quiet(rows_[index].editor);
    rows_[index].show(shown(draft_[index].text));
  }
  mark(index);
}

void ParameterForm::mark(std::size_t index) {
  const DraftedParameter& drafted = draft_[index];
  Row& row = rows_[index];
  const bool differs = drafted.differs();
  const QString name = shown(drafted.descriptor.name).replace('_', QString::fromUtf8("_\u200b"));  // may wrap there
  row.name->setText(differs ? QString::fromUtf8("• <b>") + name.toHtmlEscaped() + "</b>" : name);
  row.reset->setEnabled(differs);
  row.reset->setToolTip("back to " + shown(drafted.base));
  const std::string rule = differs ? refusalOf(drafted.descriptor, drafted.text) : "";
  row.refusal->setText(shown(rule));
  row.refusal->setVisible(!rule.empty());
  theme::mark(row.editor, !rule.empty());
}

}  // namespace pusht_rviz
