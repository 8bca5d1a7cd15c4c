// SPDX-License-Identifier: BSD-3-Clause
/// The saved views of rviz as buttons.
#pragma once

#include <QStringList>
#include <QWidget>

namespace rviz {
class ViewManager;
}

namespace pusht_rviz {

/// One button for each view that is saved in the configuration; follows it as views come and go.
class ViewButtons : public QWidget {
  Q_OBJECT

 public:
  explicit ViewButtons(QWidget* parent = nullptr);

  /// `views` must outlive the buttons.
  void setViews(rviz::ViewManager* views);

 private:
  QStringList saved() const;
  void rebuild();
  void choose(const QString& name);

  rviz::ViewManager* views_ = nullptr;
  QStringList shown_;
};

}  // namespace pusht_rviz
