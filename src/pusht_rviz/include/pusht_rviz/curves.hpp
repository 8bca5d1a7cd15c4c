// SPDX-License-Identifier: BSD-3-Clause
/// Divergence against time, as it grows.
#pragma once

#include <pusht_msgs/Divergence.h>

#include <QTimer>
#include <QVector>
#include <QWidget>
#include <array>
#include <cstddef>
#include <cstdint>

#include "pusht_rviz/curve_store.hpp"

class QCPAxisRect;
class QCPCurve;
class QCPGraph;
class QCPItemText;
class QCPLayer;
class QCustomPlot;

namespace pusht_rviz {

/// Position above, angle below: the episode under way bright, earlier ones faded, the bound as a line.
///
/// Cheap, since rviz draws in the same thread: redraws at most 15 times a second, only if something has changed, and
/// then only the layer of the episode under way, unless an axis or the earlier episodes have changed.
class Curves : public QWidget {
  Q_OBJECT

 public:
  explicit Curves(QWidget* parent = nullptr);

  void add(const pusht_msgs::Divergence& divergence);
  void clear();

  /// Beyond which a rollout has parted from the reference: [m] and [rad].
  void setBound(double position, double angle);

  const CurveStore& store() const { return store_; }

 private:
  struct Chart {
    QCPAxisRect* rect = nullptr;
    QCPItemText* title = nullptr;
    QCPGraph* bound = nullptr;
    std::array<QCPCurve*, kCurveKinds> earlier{};  ///< all of them in one; none of the null model
    std::array<QCPGraph*, kCurveKinds> now{};
  };

  void build(Aspect aspect);
  void redraw();
  bool fitAxes();
  void drawNow();
  void drawEarlier();

  CurveStore store_;
  std::array<double, kAspects> bounds_{0.03, 0.20};
  QCustomPlot* plot_;
  QCPLayer* live_;  // of the episode under way
  std::array<Chart, kAspects> charts_{};
  std::uint64_t drawn_ = 0;
  std::uint64_t drawn_earlier_ = 0;
  bool stale_ = true;  // all of it has to be drawn again
  QTimer timer_;
};

}  // namespace pusht_rviz
