// SPDX-License-Identifier: BSD-3-Clause
/// Plot of divergence against time.
#pragma once

#include <pusht_msgs/Divergence.h>

#include <QTimer>
#include <QVector>
#include <QWidget>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "curve_store.hpp"

class QCPAxisRect;
class QCPCurve;
class QCPGraph;
class QCPItemStraightLine;
class QCPItemText;
class QCPLayer;
class QCustomPlot;

namespace pusht_rviz {

/// Position above, angle below, on logarithmic axes of fixed range: one episode bright, earlier ones faded, bound and
/// floor as lines. A value beyond an axis is drawn at its end.
///
/// rviz draws in the same thread, so the plot redraws at most 15 times a second, only after a change, and only the
/// layer of the episode under way unless an axis or the earlier episodes have changed.
class Curves : public QWidget {
  Q_OBJECT

 public:
  explicit Curves(QWidget* parent = nullptr);

  void add(const pusht_msgs::Divergence& divergence);
  void recall(const std::vector<pusht_msgs::Divergence>& curve) { store_.recall(curve); }
  void clear();

  /// Sets the bound around the reference, [m] and [rad].
  void setBound(double position, double angle);

  /// Sets the mean divergence of the reference from itself, [m] and [rad]; NaN: there is none.
  void setFloor(const std::array<double, kAspects>& floor);

  /// In a replay the whole episode is drawn, with a line at the present step.
  void setReplay(bool replay);

  /// Draws an earlier episode bright until the one under way is chosen again. False: its curves are not kept.
  bool choose(std::uint64_t episode);

  /// Episode that is drawn bright.
  std::uint64_t chosen() const { return chosen_.value_or(store_.current().episode); }

  const CurveStore& store() const { return store_; }

 private:
  struct Chart {
    QCPAxisRect* rect = nullptr;
    QCPItemText* title = nullptr;
    QCPGraph* bound = nullptr;
    QCPGraph* floor = nullptr;
    QCPItemStraightLine* cursor = nullptr;
    std::array<QCPCurve*, kCurveKinds> earlier{};  ///< all episodes in one curve; none of the null model
    std::array<QCPGraph*, kCurveKinds> now{};
  };

  void build(Aspect aspect);
  void redraw();
  bool fitAxes();
  void drawNow();
  void drawEarlier();

  CurveStore store_;
  std::array<double, kAspects> bounds_{0.03, 0.20};
  std::array<double, kAspects> floor_{std::numeric_limits<double>::quiet_NaN(),
                                      std::numeric_limits<double>::quiet_NaN()};
  std::optional<std::uint64_t> chosen_;
  bool replay_ = false;
  QCustomPlot* plot_;
  QCPLayer* live_;  // has the episode under way
  std::array<Chart, kAspects> charts_{};
  std::uint64_t drawn_ = 0;          // CurveStore::version()
  std::uint64_t drawn_earlier_ = 0;  // CurveStore::earlierVersion()
  bool stale_ = true;                // everything has to be drawn again
  QTimer timer_;
};

}  // namespace pusht_rviz
