// SPDX-License-Identifier: BSD-3-Clause
/// Form of the next run.
#pragma once

#include <pusht_msgs/CompareGoal.h>
#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/RunOptions.h>
#include <rviz/properties/property_tree_model.h>
#include <rviz/properties/property_tree_widget.h>

#include <QString>
#include <QStringList>
#include <QToolButton>
#include <QWidget>
#include <optional>
#include <string>

#include "nodes.hpp"
#include "parameter_group.hpp"
#include "parameter_property.hpp"
#include "simulator_property.hpp"

namespace pusht_rviz {

/// rviz's property tree with policy, folder and spawn seed of the first episode, the options of the run as the
/// evaluator describes them, and the simulators with their parameters. The rule that a value breaks stands below it.
/// Object names: tree, reset (takes the value of the current row back, or all below it).
class NextRun : public QWidget {
  Q_OBJECT

 public:
  explicit NextRun(QWidget* parent = nullptr);

  /// Sets what the evaluator uses where a goal leaves it open: the values begin with it.
  void setRequest(const pusht_msgs::CompareGoal& request);
  void setOptions(const pusht_msgs::RunOptions& options);
  void setPolicies(const QStringList& namespaces);

  /// Takes a description of the reference or the engine, as EvaluatorLink::described().
  void setDescription(Node node, const QString& kind, const pusht_msgs::DescribeResponse& description);

  /// Tells that a run has begun. A folder takes one run, so the field moves on to nextFolder().
  void runBegan();

  /// Message that goal() still waits for, in words; empty: none.
  QString waitsFor() const;

  /// Goal of the next run: what differs from what a run would use otherwise. `rate` [control steps/s]; 0: as fast as
  /// possible; none: the evaluator's own.
  pusht_msgs::CompareGoal goal(std::optional<double> rate) const;

  /// First rule that a value breaks, without which goal() holds; empty: none.
  std::string refusal() const;

 Q_SIGNALS:
  void changed();
  void kindNeeded(int node, const QString& kind);  ///< setDescription() is to answer

 private:
  void connectRows();
  std::string option(const char* name) const;
  std::string spawnSeedRefusal() const;
  void showSpawnSeed();
  void takeSpawnSeed();
  void showPolicies();
  void moveOn();
  void refresh();
  void showReset();
  void reset();

  bool requested_ = false;  // setRequest() was called
  bool spawned_ = true;     // initial states do not come from a file
  bool overwrite_ = false;
  bool began_ = false;       // a run of this evaluator
  bool refreshing_ = false;  // rows follow from others
  QStringList policies_;     // known to the master

  rviz::PropertyTreeModel* model_;
  ParameterProperty* policy_;
  ParameterProperty* out_;
  ParameterProperty* spawn_seed_;
  ParameterGroup* options_;
  SimulatorProperty* reference_;
  SimulatorProperty* engine_;
  rviz::PropertyTreeWidget* tree_;
  QToolButton* reset_;
};

}  // namespace pusht_rviz
