// SPDX-License-Identifier: BSD-3-Clause
#include "curve_store.hpp"

#include <algorithm>
#include <utility>

#include "pusht_task/constants.hpp"

namespace pusht_rviz {

CurvePoint pointFrom(const pusht_msgs::Divergence& divergence) {
  CurvePoint point;
  point.time = pusht::kControlStep * divergence.step;
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
  if (!replay_) {
    const auto after =
        std::find_if(points.begin(), points.end(), [&](const CurvePoint& one) { return one.time >= point.time; });
    points.erase(after, points.end());
  }
  insert(point);
  cursor_ = point.time;
}

void CurveStore::insert(const CurvePoint& point) {
  std::vector<CurvePoint>& points = current_.points;
  const auto after = std::lower_bound(points.begin(), points.end(), point.time,
                                      [](const CurvePoint& one, double time) { return one.time < time; });
  if (after != points.end() && after->time == point.time) {
    *after = point;
  } else {
    points.insert(after, point);
  }
  end_ = std::max(end_, point.time);
}

void CurveStore::recall(const std::vector<pusht_msgs::Divergence>& curve) {
  for (const pusht_msgs::Divergence& divergence : curve) {
    if (current_.points.empty()) {
      current_.episode = divergence.episode;
      cursor_ = pusht::kControlStep * curve.back().step;
    }
    if (divergence.episode == current_.episode) {
      insert(pointFrom(divergence));
    }
  }
  ++version_;
}

const EpisodeCurves* CurveStore::find(std::uint64_t episode) const {
  if (current_.episode == episode && !current_.points.empty()) {
    return &current_;
  }
  const auto found = std::find_if(earlier_.begin(), earlier_.end(),
                                  [&](const EpisodeCurves& curves) { return curves.episode == episode; });
  return found == earlier_.end() ? nullptr : &*found;
}

void CurveStore::clear() {
  current_ = {};
  earlier_.clear();
  ++version_;
  ++earlier_version_;
  end_ = 0.0;
  cursor_ = 0.0;
}

}  // namespace pusht_rviz
