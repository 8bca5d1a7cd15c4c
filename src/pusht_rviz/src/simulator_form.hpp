// SPDX-License-Identifier: BSD-3-Clause
/// Form of one simulator in the next run: its kind and its parameters.
#pragma once

#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/Parameter.h>

#include <QComboBox>
#include <QGroupBox>
#include <QLabel>
#include <QString>
#include <string>
#include <vector>

#include "goal.hpp"
#include "parameter_form.hpp"

namespace pusht_rviz {

/// Built from the descriptions of the node that plays the simulator; it knows no kind by name. A choice stands,
/// whatever a run makes of the node.
class SimulatorForm : public QGroupBox {
  Q_OBJECT

 public:
  /// `node`, "reference" or "engine", is the title, and the beginning of the object names of all controls.
  explicit SimulatorForm(const QString& node, QWidget* parent = nullptr);

  /// Sets what the evaluator uses where a goal leaves it open: `kind` with its defaults and these parameters; an empty
  /// kind: the node as it is, with these parameters. The form begins anew with it.
  void setRequest(const std::string& kind, const std::vector<pusht_msgs::Parameter>& parameters);

  /// Takes the node's description of itself.
  void setNode(const pusht_msgs::DescribeResponse& description);

  /// Takes the node's description of a kind: the answer to kindNeeded().
  void setKind(const QString& kind, const pusht_msgs::DescribeResponse& description);

  /// Drops all descriptions and choices.
  void forget();

  /// Description that draft() still waits for, in words; empty: none.
  QString waitsFor() const;

  SimulatorDraft draft() const { return {kind_, parameters_->draft()}; }

 Q_SIGNALS:
  void kindNeeded(const QString& kind);  ///< the node is to describe a kind
  void changed();

 private:
  std::vector<pusht_msgs::Parameter> firstChoice(const std::string& kind) const;
  void offerKinds();
  void choose(const QString& kind);
  void build(const std::string& kind, const pusht_msgs::DescribeResponse& description);

  QString name_;
  std::string request_kind_;
  std::vector<pusht_msgs::Parameter> request_parameters_;
  pusht_msgs::DescribeResponse node_;
  bool known_ = false;    // the node has described itself
  bool pending_ = false;  // the node has not described the chosen kind yet
  QLabel* title_;
  QComboBox* kinds_;
  std::string kind_;  // that is chosen
  ParameterForm* parameters_;
};

}  // namespace pusht_rviz
