// SPDX-License-Identifier: BSD-3-Clause
/// Parameters of a simulator, or options of a run, below a row of rviz's property tree.
#pragma once

#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/Parameter.h>
#include <pusht_msgs/RunOptions.h>
#include <rviz/properties/enum_property.h>

#include <string>
#include <vector>

#include "parameter_property.hpp"

namespace pusht_rviz {

/// Row with a row for each parameter below it. It knows no parameter by name.
///
/// After an edit: the base of each parameter is set anew, since a goal names the words that differ, and their presets
/// set others; a parameter that did not differ from its base before follows it.
class ParameterGroup : public rviz::EnumProperty {
  Q_OBJECT

 public:
  ParameterGroup(const QString& name, rviz::Property* parent) : EnumProperty(name, "", "", parent) {}

  /// Parameters of a simulator, from its defaults, and those of the loop beside it; `chosen` is written over the texts
  /// of the parameters of those names.
  void build(const pusht_msgs::DescribeResponse& simulator, const std::vector<pusht_msgs::Parameter>& chosen);

  /// Options of a run, from the values that an evaluator uses where a goal leaves them open.
  void build(const pusht_msgs::RunOptions& options);

  /// Takes all rows away.
  void clear();

  std::vector<ParameterProperty*> parameters() const;
  /// Row of the parameter `name`; null if there is none.
  ParameterProperty* find(const std::string& name) const;

  /// What a goal must name so that a run uses what is shown.
  std::vector<pusht_msgs::Parameter> named() const;

  /// First rule that a text breaks; empty: none.
  std::string refusal() const;

 Q_SIGNALS:
  void edited();  ///< a row, or all

 private:
  void add(const pusht_msgs::ParameterDescriptor& descriptor, const std::string& initial, bool always_named = false);
  void follow(const ParameterProperty* changed);
  void rebase();

  bool quiet_ = false;  // texts are set, not edited
};

}  // namespace pusht_rviz
