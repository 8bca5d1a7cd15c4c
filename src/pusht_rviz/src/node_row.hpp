// SPDX-License-Identifier: BSD-3-Clause
/// Row of the nodes of a comparison.
#pragma once

#include <QLabel>
#include <QString>
#include <QStringList>
#include <QWidget>
#include <array>

#include "nodes.hpp"

namespace pusht_rviz {

/// A sign and a name for each node, as a label with the object name node.NAME: whether it is there, and works. Signs
/// differ in shape and color. In a replay the player alone is shown.
class NodeRow : public QWidget {
  Q_OBJECT

 public:
  explicit NodeRow(QWidget* parent = nullptr);

  void setStatuses(const NodeStatuses& statuses) { statuses_ = statuses; }

  /// Shows all nodes. `busy`: a run is under way.
  void show(bool busy, bool replay);

  /// A line for each node that is lost, does not answer, or failed at its start.
  QStringList complaints() const;

 private:
  std::array<QLabel*, kNodes> labels_{};
  NodeStatuses statuses_{};
};

}  // namespace pusht_rviz
