// SPDX-License-Identifier: BSD-3-Clause
/// Rows of the form of the next run, for tests.
#pragma once

#include <rviz/properties/property.h>
#include <rviz/properties/property_tree_model.h>
#include <rviz/properties/property_tree_widget.h>

#include <QStringList>
#include <QWidget>

#include "parameter_property.hpp"

namespace pusht_rviz {

/// Row of a property tree by its path, e.g. "engine/block_damp"; null if there is none.
inline rviz::Property* rowIn(const rviz::PropertyTreeWidget& tree, const QString& path) {
  rviz::Property* row = tree.getModel()->getRoot();
  for (const QString& name : path.split('/')) {
    rviz::Property* found = nullptr;
    for (int i = 0; row != nullptr && i < row->numChildren(); ++i) {
      found = row->childAt(i)->getName() == name ? row->childAt(i) : found;
    }
    row = found;
  }
  return row;
}

/// Value of a row; empty if there is none.
inline QString valueIn(const rviz::PropertyTreeWidget& tree, const QString& path) {
  const rviz::Property* const row = rowIn(tree, path);
  return row == nullptr ? "" : row->getValue().toString();
}

/// Rule that is shown below a row; empty: none.
inline QString ruleBelow(const rviz::PropertyTreeWidget& tree, const QString& path) {
  const rviz::Property* const row = rowIn(tree, path);
  return row == nullptr || row->numChildren() == 0 ? "" : row->childAt(0)->getName();
}

}  // namespace pusht_rviz
