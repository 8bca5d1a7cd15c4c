// SPDX-License-Identifier: BSD-3-Clause
/// What a simulator is to be in the next run: its kind, and its parameters.
#pragma once

#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/Parameter.h>

#include <QComboBox>
#include <QGridLayout>
#include <QGroupBox>
#include <QLabel>
#include <QString>
#include <QToolButton>
#include <QWidget>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "pusht_rviz/goal.hpp"

namespace pusht_rviz {

/// Built from what the node says of itself; knows no simulator.
class SimulatorForm : public QGroupBox {
  Q_OBJECT

 public:
  /// `role`, "reference" or "engine", is the title, and the beginning of the names of all controls.
  explicit SimulatorForm(const QString& role, QWidget* parent = nullptr);

  /// What the evaluator takes if nothing is said: with a kind, its defaults and these parameters.
  void setRequest(const std::string& kind, const std::vector<pusht_msgs::Parameter>& parameters);

  /// What the node is now.
  void setNode(const pusht_msgs::DescribeResponse& description);

  /// What the node would be as a kind.
  void setKind(const QString& kind, const pusht_msgs::DescribeResponse& description);

  /// Everything is as it was before anybody said anything.
  void forget();

  /// What has to come before draft() says what people chose: "engine: waiting for ..."; empty: nothing.
  QString waitsFor() const;

  const SimulatorDraft& draft() const { return draft_; }

 Q_SIGNALS:
  void kindNeeded(const QString& kind);  ///< answer with setKind()
  void changed();

 private:
  /// The widgets of a setting.
  struct Row {
    QLabel* name = nullptr;
    QWidget* editor = nullptr;
    QToolButton* reset = nullptr;
    QLabel* refusal = nullptr;
    std::function<void(const QString&)> show;
  };

  /// What the parameters of a kind are at first: what the evaluator asks for; if it leaves the kind open, on top of
  /// what a node of that kind has. The others have their defaults.
  std::vector<pusht_msgs::Parameter> firstChoice(const std::string& kind) const;
  void choose(const QString& kind);
  void build(const SimulatorDraft& draft);
  void addRow(const Setting& setting, int line);
  void edit(std::size_t row, const QString& text);
  void show(std::size_t row);
  void mark(std::size_t row);

  QString role_;
  std::string request_kind_;
  std::vector<pusht_msgs::Parameter> request_parameters_;
  pusht_msgs::DescribeResponse node_;
  bool known_ = false;    // whether the node has said anything
  bool pending_ = false;  // the chosen kind has not been described yet
  QLabel* title_;
  QComboBox* kinds_;
  QWidget* parameters_;
  SimulatorDraft draft_;
  std::vector<Row> rows_;  // of its settings
};

}  // namespace pusht_rviz
