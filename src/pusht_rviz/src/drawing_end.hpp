// SPDX-License-Identifier: BSD-3-Clause
/// The end of rviz's drawing.
#pragma once

#include <rviz/render_panel.h>
#include <rviz/visualization_manager.h>

#include <QEvent>
#include <QObject>
#include <QPlatformSurfaceEvent>
#include <QWindow>

namespace pusht_rviz {

/// Ends rviz's drawing when its window goes. rviz would draw a frame or two more, and Mesa (22.3), which cannot ask for
/// the size of a window that is gone, writes beyond its buffers: rviz then dies of a broken heap as it closes.
class DrawingEnd : public QObject {
 public:
  DrawingEnd(rviz::VisualizationManager* manager, QObject* parent) : QObject(parent), manager_(manager) {
    if (QWindow* const window = manager->getRenderPanel()->windowHandle()) {
      window->installEventFilter(this);
    }
  }

  bool eventFilter(QObject* watched, QEvent* event) override {
    if (event->type() == QEvent::PlatformSurface && static_cast<QPlatformSurfaceEvent*>(event)->surfaceEventType() ==
                                                        QPlatformSurfaceEvent::SurfaceAboutToBeDestroyed) {
      manager_->stopUpdate();
    }
    return QObject::eventFilter(watched, event);
  }

 private:
  rviz::VisualizationManager* manager_;
};

}  // namespace pusht_rviz
