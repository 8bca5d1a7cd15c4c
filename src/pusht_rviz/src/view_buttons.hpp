// SPDX-License-Identifier: BSD-3-Clause
/// Buttons for the saved views of rviz.
#pragma once

#include <QStringList>
#include <QWidget>

namespace rviz {
class ViewManager;
}

namespace pusht_rviz {

/// A button for each view that is saved in the configuration, at most six. It looks twice a second whether views came
/// or went. Object names: view.NAME.
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
