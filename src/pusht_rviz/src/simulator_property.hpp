// SPDX-License-Identifier: BSD-3-Clause
/// Simulator of the next run as a row of rviz's property tree: its kind, and its parameters below.
#pragma once

#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/Parameter.h>

#include <QString>
#include <QVariant>
#include <string>
#include <vector>

#include "parameter_group.hpp"

namespace pusht_rviz {

/// Built from the descriptions of the node that plays the simulator; it knows no kind by name. A choice stands,
/// whatever a run makes of the node.
class SimulatorProperty : public ParameterGroup {
  Q_OBJECT

 public:
  /// `node`: "reference" or "engine".
  SimulatorProperty(const QString& node, rviz::Property* parent);

  /// Sets what the evaluator uses where a goal leaves it open: `kind` with its defaults and these parameters; an empty
  /// kind: the node as it is, with these parameters. The choice begins anew with it.
  void setRequest(const std::string& kind, const std::vector<pusht_msgs::Parameter>& parameters);

  /// Takes the node's description of itself.
  void setNode(const pusht_msgs::DescribeResponse& description);

  /// Takes the node's description of a kind: the answer to kindNeeded().
  void setKind(const QString& kind, const pusht_msgs::DescribeResponse& description);

  /// Description that is still waited for, or why the node refused it, in words; empty: none.
  QString waitsFor() const;

  /// Kind that is chosen; empty: the node has not described itself.
  std::string kind() const { return kind_; }

  QVariant getViewData(int column, int role) const override;

 Q_SIGNALS:
  void kindNeeded(const QString& kind);  ///< the node is to describe a kind

 private:
  void offerKinds();
  void choose(const std::string& kind);
  void finish(const std::string& kind, const pusht_msgs::DescribeResponse& description);
  void note(const QString& text);

  std::string request_kind_;
  std::vector<pusht_msgs::Parameter> request_parameters_;
  pusht_msgs::DescribeResponse node_;
  bool known_ = false;    // the node has described itself
  bool pending_ = false;  // the node has not described the chosen kind yet
  std::string refusal_;   // why it did not
  QString note_;          // shown in place of a kind that can be chosen; empty: there is a choice
  std::string kind_;
};

}  // namespace pusht_rviz
