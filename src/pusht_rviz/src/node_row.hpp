// SPDX-License-Identifier: BSD-3-Clause
/// Row of the nodes of a comparison.
#pragma once

#include <pusht_msgs/DescribeResponse.h>

#include <QLabel>
#include <QString>
#include <QStringList>
#include <QWidget>
#include <array>
#include <string>

#include "nodes.hpp"
#include "service_channel.hpp"

namespace pusht_rviz {

/// A sign and a name for each node, as a label with the object name node.NAME: whether it is there, and works. Signs
/// differ in shape and color. In a replay the player alone is shown.
class NodeRow : public QWidget {
  Q_OBJECT

 public:
  explicit NodeRow(QWidget* parent = nullptr);

  void setPresence(Node node, Presence presence) { states_.at(node).presence = presence; }

  /// Takes a node's description of itself.
  void setDescription(Node node, const pusht_msgs::DescribeResponse& description);

  /// Shows all nodes. `busy`: a run is under way.
  void show(bool busy, bool replay);

  /// A line for each node that is lost, does not answer, or failed at its start.
  QStringList complaints() const;

 private:
  struct State {
    QLabel* label = nullptr;
    Presence presence = Presence::kWaiting;
    QString title{};  // of a simulator or policy
    QString fault{};  // error with which the node failed at its start; empty: it came up
  };

  std::array<State, kNodes> states_{};
};

}  // namespace pusht_rviz
