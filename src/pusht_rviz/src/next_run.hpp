// SPDX-License-Identifier: BSD-3-Clause
/// Form of the next run.
#pragma once

#include <pusht_msgs/CompareGoal.h>
#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/RunOptions.h>

#include <QComboBox>
#include <QLabel>
#include <QLineEdit>
#include <QString>
#include <QStringList>
#include <QWidget>

#include "goal.hpp"
#include "nodes.hpp"
#include "parameter_form.hpp"
#include "simulator_form.hpp"

namespace pusht_rviz {

/// Options of the run as the evaluator describes them, spawn seed of the first episode, policy, folder, simulators. The
/// rule that a field breaks stands below it.
class NextRun : public QWidget {
  Q_OBJECT

 public:
  explicit NextRun(QWidget* parent = nullptr);

  /// Sets what the evaluator uses where a goal leaves it open: the controls begin with it.
  void setRequest(const pusht_msgs::CompareGoal& request);
  void setOptions(const pusht_msgs::RunOptions& options);
  void setPolicies(const QStringList& namespaces);

  /// Takes a description of the reference or the engine, as EvaluatorLink::described(); others are ignored.
  void setDescription(Node node, const QString& kind, const pusht_msgs::DescribeResponse& description);

  /// Tells that a run has begun. A folder takes one run, so the field moves on to nextFolder().
  void runBegan();

  /// Message that draft() still waits for, in words; empty: none.
  QString waitsFor() const;

  /// Content of the form; without a rate.
  RunDraft draft() const;

 Q_SIGNALS:
  void changed();
  void kindNeeded(int node, const QString& kind);  ///< setDescription() is to answer

 private:
  QWidget* runGroup();
  void connectControls();
  void showSpawnSeed();
  void takeSpawnSeed();
  void refresh();
  void showPolicies();
  void moveOn();

  bool requested_ = false;  // setRequest() was called
  bool spawned_ = true;     // initial states do not come from a file
  bool overwrite_ = false;
  bool began_ = false;  // a run of this evaluator
  ParameterForm* options_;
  QLineEdit* spawn_seed_;
  QLabel* spawn_seed_refusal_;
  QLineEdit* out_;
  QComboBox* policy_;
  QStringList policies_;    // known to the master
  QString default_policy_;  // of the evaluator
  SimulatorForm* reference_;
  SimulatorForm* engine_;
};

}  // namespace pusht_rviz
