// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/curve_store.hpp"

#include <algorithm>
#include <utility>

namespace pusht_rviz {

CurvePoint pointFrom(const pusht_msgs::Divergence& divergence) {
  CurvePoint point;
  point.time = kControlStep * divergence.step;
  point.values[kReplayCurve] = {divergence.replay_position, divergence.replay_angle};
  point.values[kClosedCurve] = {divergence.closed_position, divergence.closed_angle};
  point.values[kNullCurve] = {divergence.null_position, divergence.null_angle};
  return point;
}

void CurveStore::add(const pusht_msgs::Divergence& divergence) {
  const CurvePoint point = pointFrom(divergence);
  ++version_;
  if (divergence.episode != current_.episode) {
    if (!current_.points.empty()) {
      earlier_.push_back(std::exchange(current_, {}));
      ++earlier_version_;
    }
    const auto same = std::remove_if(earlier_.begin(), earlier_.end(),
                                     [&](const EpisodeCurves& curves) { return curves.episode == divergence.episode; });
    if (same != earlier_.end()) {
      earlier_.erase(same, earlier_.end());
      ++earlier_version_;
    }
    if (earlier_.size() > kKept) {
      earlier_.pop_front();
    }
    current_.episode = divergence.episode;
  }
  std::vector<CurvePoint>& points = current_.points;
  while (!points.empty() && points.back().time >= point.time) {
    points.pop_back();
  }
  points.push_back(point);
  end_ = std::max(end_, point.time);
  for (const std::size_t aspect : {kPosition, kAngle}) {
    for (const std::size_t kind : {kReplayCurve, kClosedCurve}) {
      const double value = point.values[kind][aspect];
      if (value > greatest_[aspect]) {  // not so if it is NaN
        greatest_[aspect] = value;
      }
    }
  }
}

void CurveStore::clear() {
  current_ = {};
  earlier_.clear();
  ++version_;
  ++earlier_version_;
  end_ = 0.0;
  greatest_ = {};
}

}  // namespace pusht_rviz
