// SPDX-License-Identifier: BSD-3-Clause
/// Guard against the mouse wheel.
#pragma once

#include <QEvent>
#include <QObject>
#include <QWidget>

namespace pusht_rviz {

/// Makes a widget ignore the wheel unless it has the focus: scrolling a form must not change the fields under the
/// pointer.
inline void quietWheel(QWidget* widget) {
  class Filter : public QObject {
   public:
    using QObject::QObject;
    bool eventFilter(QObject* watched, QEvent* event) override {
      const bool scrolls = event->type() == QEvent::Wheel && !static_cast<QWidget*>(watched)->hasFocus();
      if (scrolls) {
        event->ignore();
      }
      return scrolls;
    }
  };
  widget->setFocusPolicy(Qt::StrongFocus);
  widget->installEventFilter(new Filter(widget));
}

}  // namespace pusht_rviz
