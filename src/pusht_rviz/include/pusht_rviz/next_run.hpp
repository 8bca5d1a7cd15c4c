// SPDX-License-Identifier: BSD-3-Clause
/// The form of the next run.
#pragma once

#include <pusht_msgs/CompareGoal.h>
#include <pusht_msgs/DescribeResponse.h>

#include <QComboBox>
#include <QLabel>
#include <QLineEdit>
#include <QString>
#include <QStringList>
#include <QWidget>
#include <cstdint>
#include <optional>

#include "pusht_rviz/goal.hpp"
#include "pusht_rviz/letters.hpp"
#include "pusht_rviz/simulator_form.hpp"

namespace pusht_rviz {

/// Says beside each field which rule it breaks; draft() has the goal, and all that is refused.
class NextRun : public QWidget {
  Q_OBJECT

 public:
  explicit NextRun(QWidget* parent = nullptr);

  /// What the evaluator takes if nothing is said: the controls begin with it.
  void setRequest(const pusht_msgs::CompareGoal& request, const QString& policy);
  void setPolicies(const QStringList& namespaces);
  void setDescription(Role role, const QString& kind, const pusht_msgs::DescribeResponse& description);
  void setEvaluator(const QString& name);
  void forget();

  /// A run has begun. A folder takes one run, so the name of the folder moves on: nextFolder().
  void runBegan();

  /// What has to come before draft() says what people chose; empty: nothing.
  QString waitsFor() const;

  /// Without a rate.
  RunDraft draft() const;

 Q_SIGNALS:
  void changed();
  void kindNeeded(int role, const QString& kind);
  void evaluatorChosen(const QString& name);

 private:
  struct Field {
    QLineEdit* edit;
    QLabel* refusal;
  };

  Field makeField(const char* name, const char* tip);
  void coupleFromEpisode();
  void coupleFromSeed();
  void refresh();
  void showPolicies();
  void moveOn();

  Field episodes_;
  Field run_seed_;
  Field first_episode_;
  Field spawn_seed_;
  Field out_;
  bool known_ = false;  // what the evaluator takes if nothing is said
  bool spawned_ = true;
  bool overwrite_ = false;
  bool began_ = false;  // a run of this evaluator
  std::optional<std::uint32_t> requested_episodes_;
  QComboBox* policy_;
  QStringList policies_;    // that there are
  QString default_policy_;  // the evaluator's
  QLineEdit* evaluator_;
  SimulatorForm* reference_;
  SimulatorForm* engine_;
};

}  // namespace pusht_rviz
