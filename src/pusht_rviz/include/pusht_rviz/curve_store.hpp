// SPDX-License-Identifier: BSD-3-Clause
/// The divergence of the last episodes, as it comes in. Without widgets.
#pragma once

#include <pusht_msgs/Divergence.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <vector>

namespace pusht_rviz {

inline constexpr double kControlStep = 0.1;  ///< [s]

/// What is drawn of an episode, in this order.
enum CurveKind : std::size_t { kReplayCurve, kClosedCurve, kNullCurve };
inline constexpr std::size_t kCurveKinds = 3;

/// What is shown of each curve: the position [m] and the angle [rad].
enum Aspect : std::size_t { kPosition, kAngle };
inline constexpr std::size_t kAspects = 2;

/// The divergence after one control step; NaN where one of the two worlds has ended.
struct CurvePoint {
  double time = 0.0;                                               ///< [s] since the start
  std::array<std::array<double, kAspects>, kCurveKinds> values{};  ///< [m] and [rad]
};

/// Point of the curves at the control step of a message.
CurvePoint pointFrom(const pusht_msgs::Divergence& divergence);

/// One episode: its points in the order of time.
struct EpisodeCurves {
  std::uint64_t episode = 0;
  std::vector<CurvePoint> points;
};

/// The episode under way, and a bounded number of earlier ones.
class CurveStore {
 public:
  static constexpr std::size_t kKept = 50;  ///< earlier episodes

  /// Curves of a replay: a step that is not after the last one forgets nothing, since it was only sought.
  void setReplay(bool replay) { replay_ = replay; }

  /// A step of another episode ends the one under way. In a live run, a step that is not after the last one means that
  /// the episode began again: what came from there on is forgotten. So is an earlier course of the same episode.
  void add(const pusht_msgs::Divergence& divergence);
  /// Steps that were missed: those of the episode under way that are not there yet.
  void recall(const std::vector<pusht_msgs::Divergence>& curve);
  void clear();

  /// The curves of an episode, the one under way or an earlier one; null if they are not kept.
  const EpisodeCurves* find(std::uint64_t episode) const;

  double cursor() const { return cursor_; }  ///< [s] time of the step that came last

  const EpisodeCurves& current() const { return current_; }
  const std::deque<EpisodeCurves>& earlier() const { return earlier_; }  ///< oldest first

  std::uint64_t version() const { return version_; }                 ///< grows with each change
  std::uint64_t earlierVersion() const { return earlier_version_; }  ///< with each change of earlier()

  double end() const { return end_; }  ///< [s] the last time of all that was added since clear()

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
