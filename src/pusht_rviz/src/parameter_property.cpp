// SPDX-License-Identifier: BSD-3-Clause
#include "parameter_property.hpp"

#include <rviz/properties/property_tree_model.h>

#include <QFont>
#include <algorithm>
#include <cstdint>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/parameters.hpp"
#include "theme.hpp"

namespace pusht_rviz {
namespace {

/// Value of the type that a descriptor names; a text for any other name.
pusht::ParameterValue valueOfType(const std::string& type) {
  if (type == "boolean") {
    return false;
  }
  if (type == "integer") {
    return std::int64_t{0};
  }
  return type == "real" ? pusht::ParameterValue(0.0) : pusht::ParameterValue(std::string());
}

/// The descriptor as the task has it: the rules are the simulators' own.
pusht::ParameterDescriptor ruleOf(const pusht_msgs::ParameterDescriptor& parameter) {
  pusht::ParameterDescriptor rule{parameter.name,  parameter.unit,    "", valueOfType(parameter.type),
                                  parameter.least, parameter.greatest};
  rule.words = parameter.words;
  return rule;
}

/// Whether a text is an integer beyond those of ParameterDescriptor, as a seed may be.
bool isLargeInteger(const std::string& text) {
  return !pusht::decimal<std::int64_t>(text) && pusht::decimal<std::uint64_t>(text);
}

/// Meaning, range and default.
QString descriptionOf(const pusht_msgs::ParameterDescriptor& parameter) {
  QStringList lines;
  for (const std::string& line : {parameter.meaning, rangeOf(parameter),
                                  parameter.default_value.empty() ? "" : "default: " + parameter.default_value}) {
    if (!line.empty()) {
      lines << QString::fromStdString(line);
    }
  }
  return lines.join("\n");
}

/// Row below a parameter: the rule that its text breaks, without name and text, which stand above it.
class Rule : public rviz::Property {
 public:
  using rviz::Property::Property;
  QVariant getViewData(int column, int role) const override {
    if (role == Qt::ForegroundRole) {
      return theme::kBad;
    }
    if (role == Qt::ToolTipRole) {
      return getName();
    }
    return column == 0 && role == Qt::DisplayRole ? getName().section(": ", 1) : Property::getViewData(column, role);
  }
};

}  // namespace

std::string refusalOf(const pusht_msgs::ParameterDescriptor& parameter, const std::string& text) {
  if (parameter.type == "integer" && parameter.greatest > 0x1p63 && isLargeInteger(text)) {
    return "";
  }
  try {
    ruleOf(parameter).read(text);
    return "";
  } catch (const pusht::InvalidInput& refusal) {
    return refusal.what();
  }
}

std::string rangeOf(const pusht_msgs::ParameterDescriptor& parameter) { return ruleOf(parameter).range(); }

std::optional<std::string> textAmong(const std::vector<pusht_msgs::Parameter>& parameters, const std::string& name) {
  const auto found = std::find_if(parameters.rbegin(), parameters.rend(),
                                  [&](const auto& candidate) { return candidate.name == name; });
  return found == parameters.rend() ? std::nullopt : std::optional<std::string>(found->value);
}

ParameterProperty::ParameterProperty(pusht_msgs::ParameterDescriptor descriptor, const std::string& initial,
                                     bool always_named, rviz::Property* parent)
    : EnumProperty(QString::fromStdString(descriptor.name), "", descriptionOf(descriptor), parent),
      descriptor_(std::move(descriptor)),
      initial_(initial),
      base_(initial),
      always_named_(always_named),
      has_words_(!descriptor_.words.empty()),
      suffix_(QString::fromStdString(descriptor_.unit)),
      rule_([this] { return differs() ? refusalOf(descriptor_, text()) : std::string(); }) {
  if (descriptor_.type == "boolean") {
    value_ = false;  // rviz shows a check box
  }
  for (const std::string& word : descriptor_.words) {
    addOptionStd(word);
  }
  setText(initial);
}

std::string ParameterProperty::text() const { return getValue().toString().toStdString(); }

void ParameterProperty::setText(const std::string& text) {
  if (descriptor_.type == "boolean") {
    setValue(text == "true");
  } else {
    setValue(QString::fromStdString(text));
  }
}

void ParameterProperty::setBase(const std::string& base) {
  base_ = base;
  redraw();
}

bool ParameterProperty::differs() const {
  const std::string now = text();
  if (now == base_) {
    return false;
  }
  const std::optional<double> number =
      descriptor_.type == "real" ? pusht::decimal<double>(now) : std::optional<double>();
  return !number || number != pusht::decimal<double>(base_);
}

void ParameterProperty::showRule() {
  const QString rule = QString::fromStdString(refusal());
  if (rule.isEmpty()) {
    if (numChildren() > 0) {
      removeChildren();
    }
  } else if (numChildren() == 0) {
    addChild(new Rule(rule));
    expand();
  } else {
    childAt(0)->setName(rule);
  }
  redraw();
}

void ParameterProperty::setWords(const QStringList& words) {
  has_words_ = true;
  clearOptions();
  for (const QString& word : words) {
    addOption(word);
  }
}

void ParameterProperty::setSuffix(const QString& suffix) {
  suffix_ = suffix;
  redraw();
}

void ParameterProperty::setPlaceholder(const QString& placeholder) {
  placeholder_ = placeholder;
  redraw();
}

void ParameterProperty::redraw() {
  if (model_ != nullptr) {
    model_->emitDataChanged(this, false);
  }
}

bool ParameterProperty::setValue(const QVariant& value) {
  return EnumProperty::setValue(descriptor_.type == "boolean" ? value : QVariant(value.toString().trimmed()));
}

QVariant ParameterProperty::getViewData(int column, int role) const {
  const bool marked = differs();
  switch (role) {
    case Qt::ToolTipRole:
      return getName() + "\n" + getDescription() + (marked ? "\notherwise: " + QString::fromStdString(base_) : "");
    case Qt::ForegroundRole:
      if (!refusal().empty()) {
        return theme::kBad;
      }
      return column == 1 && text().empty() ? QVariant(theme::kDim) : QVariant();
    case Qt::FontRole: {
      QFont font;
      font.setBold(marked);
      return marked ? QVariant(font) : QVariant();
    }
    case Qt::DisplayRole:
      if (column == 0) {
        return (marked ? QString::fromUtf8("• ") : "") + getName();
      }
      if (descriptor_.type == "boolean") {
        return {};
      }
      return text().empty() ? placeholder_ : getValue().toString() + (suffix_.isEmpty() ? "" : " " + suffix_);
    default:
      return EnumProperty::getViewData(column, role);
  }
}

QWidget* ParameterProperty::createEditor(QWidget* parent, const QStyleOptionViewItem& option) {
  if (has_words_) {
    return EnumProperty::createEditor(parent, option);
  }
  return Property::createEditor(parent, option);  // NOLINT(bugprone-parent-virtual-call): a field, not a list of words
}

}  // namespace pusht_rviz
