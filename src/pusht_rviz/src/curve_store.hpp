// SPDX-License-Identifier: BSD-3-Clause
/// Store of the divergence of the last episodes, for plots. Without widgets.
#pragma once

#include <pusht_msgs/Divergence.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <vector>

namespace pusht_rviz {

/// Curves of an episode, in the order in which they are drawn: replay and closed loop against the reference, and a tee
/// that never moves.
enum CurveKind : std::size_t { kReplayCurve, kClosedCurve, kNullCurve };
inline constexpr std::size_t kCurveKinds = 3;

/// Component of a divergence: position [m] or angle [rad].
enum Aspect : std::size_t { kPosition, kAngle };
inline constexpr std::size_t kAspects = 2;

/// Divergence after one control step; NaN where one of the two worlds has ended.
struct CurvePoint {
  double time = 0.0;                                               ///< [s] since the initial state
  std::array<std::array<double, kAspects>, kCurveKinds> values{};  ///< [m] and [rad]
};

/// Point of the curves at the control step of a message.
CurvePoint pointFrom(const pusht_msgs::Divergence& divergence);

/// Points of one episode in the order of time.
struct EpisodeCurves {
  std::uint64_t episode = 0;
  std::vector<CurvePoint> points;
};

/// Curves of the episode under way and of a bounded number of earlier ones.
class CurveStore {
 public:
  static constexpr std::size_t kKept = 50;  ///< most earlier episodes

  /// Whether the curves are of a replay: there a step that is not after the last one was sought, and drops nothing.
  void setReplay(bool replay) { replay_ = replay; }

  /// Adds a step. If it is of another episode, the one under way becomes an earlier one. In a live run a step that is
  /// not after the last one means that the episode began again, so points from that step on are dropped; so are the
  /// points of an earlier attempt at the same episode.
  void add(const pusht_msgs::Divergence& divergence);

  /// Adds steps of the episode under way that were missed.
  void recall(const std::vector<pusht_msgs::Divergence>& curve);
  void clear();

  /// Curves of an episode; null if they are not kept.
  const EpisodeCurves* find(std::uint64_t episode) const;

  double cursor() const { return cursor_; }  ///< [s] time of the last step that was added

  const EpisodeCurves& current() const { return current_; }
  const std::deque<EpisodeCurves>& earlier() const { return earlier_; }  ///< oldest first

  std::uint64_t version() const { return version_; }                 ///< grows with every change
  std::uint64_t earlierVersion() const { return earlier_version_; }  ///< grows with every change of earlier()

  double end() const { return end_; }  ///< [s] greatest time since clear()

 private:
  void insert(const CurvePoint& point);

  EpisodeCurves current_;
  std::deque<EpisodeCurves> earlier_;
  std::uint64_t version_ = 0;
  std::uint64_t earlier_version_ = 0;
  double end_ = 0.0;
  double cursor_ = 0.0;
  bool replay_ = false;
};

}  // namespace pusht_rviz
