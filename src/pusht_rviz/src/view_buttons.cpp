// SPDX-License-Identifier: BSD-3-Clause
#include "view_buttons.hpp"

#include <rviz/view_controller.h>
#include <rviz/view_manager.h>

#include <QHBoxLayout>
#include <QPushButton>
#include <QTimer>
#include <utility>

namespace pusht_rviz {
namespace {

constexpr int kLook = 500;  // [ms] period: rviz does not tell when its configuration is loaded
constexpr int kMost = 6;    // more do not fit

/// Name that is short enough for a row of buttons.
QString shortName(const QString& view) {
  for (const auto& [name, brief] : {std::pair("All three", "All"), std::pair("Left table", "Left"),
                                    std::pair("Middle table", "Middle"), std::pair("Right table", "Right")}) {
    if (view == name) {
      return brief;
    }
  }
  return view;
}

}  // namespace

ViewButtons::ViewButtons(QWidget* parent) : QWidget(parent) {
  auto* const row = new QHBoxLayout(this);
  row->setContentsMargins(0, 0, 0, 0);
  row->setSpacing(4);
  hide();
}

void ViewButtons::setViews(rviz::ViewManager* views) {
  views_ = views;
  auto* const timer = new QTimer(this);
  connect(timer, &QTimer::timeout, this, &ViewButtons::rebuild);
  timer->start(kLook);
  rebuild();
}

QStringList ViewButtons::saved() const {
  QStringList names;
  for (int i = 0; i < views_->getNumViews() && names.size() < kMost; ++i) {
    names << views_->getViewAt(i)->getName();
  }
  return names;
}

void ViewButtons::rebuild() {
  const QStringList names = saved();
  if (names == shown_) {
    return;
  }
  shown_ = names;
  for (QPushButton* const button : findChildren<QPushButton*>()) {
    button->deleteLater();
    layout()->removeWidget(button);
  }
  for (const QString& name : names) {
    auto* const button = new QPushButton(shortName(name), this);
    button->setObjectName("view." + shortName(name));
    button->setToolTip("view: " + name);
    button->setMinimumWidth(10);
    connect(button, &QPushButton::clicked, this, [this, name] { choose(name); });
    layout()->addWidget(button);
  }
  setVisible(!names.isEmpty());
}

void ViewButtons::choose(const QString& name) {
  for (int i = 0; i < views_->getNumViews(); ++i) {
    if (rviz::ViewController* const view = views_->getViewAt(i); view->getName() == name) {
      views_->setCurrentFrom(view);
      return;
    }
  }
}

}  // namespace pusht_rviz
