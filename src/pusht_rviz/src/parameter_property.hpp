// SPDX-License-Identifier: BSD-3-Clause
/// Parameter of a simulator, or option of a run, as a row of rviz's property tree.
#pragma once

#include <pusht_msgs/Parameter.h>
#include <pusht_msgs/ParameterDescriptor.h>
#include <rviz/properties/enum_property.h>

#include <QString>
#include <QStringList>
#include <QVariant>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pusht_rviz {

/// Rule that `text` breaks as a value of this parameter, with name and text; empty: it breaks none.
std::string refusalOf(const pusht_msgs::ParameterDescriptor& parameter, const std::string& text);

/// Values that a parameter takes, in words: "from 0.0 to 100.0 [1/s]"; empty: all of its type.
std::string rangeOf(const pusht_msgs::ParameterDescriptor& parameter);

/// Text of the last parameter of that name; none if there is none.
std::optional<std::string> textAmong(const std::vector<pusht_msgs::Parameter>& parameters, const std::string& name);

/// Row of one parameter: a check box, a list of words or a text, marked where it differs from its base. A text that
/// breaks a rule stays as typed; showRule() shows the rule in a row below.
class ParameterProperty : public rviz::EnumProperty {
  Q_OBJECT

 public:
  /// `initial`: value unless a goal names it or a preset sets it. `always_named`: its default is not known, so a goal
  /// must name it.
  ParameterProperty(pusht_msgs::ParameterDescriptor descriptor, const std::string& initial, bool always_named,
                    rviz::Property* parent);

  const pusht_msgs::ParameterDescriptor& descriptor() const { return descriptor_; }
  const std::string& initial() const { return initial_; }

  /// Value that is wanted.
  std::string text() const;
  void setText(const std::string& text);

  /// Value unless a goal names it: `initial`, or what a preset that the goal names sets.
  const std::string& base() const { return base_; }
  void setBase(const std::string& base);

  /// Whether the text stands for another value than the base: 6 and 6.0 are one real number.
  bool differs() const;

  /// Whether a goal must name it.
  bool named() const { return always_named_ || differs(); }

  /// Rule that the text breaks; empty: none. By default that of the descriptor, for a text that differs.
  std::string refusal() const { return rule_(); }
  void setRule(std::function<std::string()> rule) { rule_ = std::move(rule); }

  /// Shows the rule that is broken in a row below, or takes that row away.
  void showRule();

  void setWords(const QStringList& words);
  void setSuffix(const QString& suffix);            ///< behind the value; at first the unit
  void setPlaceholder(const QString& placeholder);  ///< in place of an empty text

  bool setValue(const QVariant& value) override;
  QVariant getViewData(int column, int role) const override;
  QWidget* createEditor(QWidget* parent, const QStyleOptionViewItem& option) override;

 private:
  void redraw();

  pusht_msgs::ParameterDescriptor descriptor_;
  std::string initial_;
  std::string base_;
  bool always_named_;
  bool has_words_;
  QString suffix_;
  QString placeholder_;
  std::function<std::string()> rule_;
};

}  // namespace pusht_rviz
