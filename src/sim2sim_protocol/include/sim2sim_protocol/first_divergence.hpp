// SPDX-License-Identifier: BSD-3-Clause
/// When and how two rollouts of an episode part, and how fast small differences grow. All of it comes of traces, so it
/// is the same for every simulator, live, in batch and from a bag.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "pusht_task/constants.hpp"
#include "pusht_task/rollout.hpp"
#include "sim2sim_protocol/divergence.hpp"

namespace sim2sim {

/// How far apart two tees may be and still count as together: by default what the task itself tolerates.
struct Bound {
  double position = pusht::kPositionTolerance;  ///< [m]
  double angle = pusht::kAngleTolerance;        ///< [rad]

  /// Throws InvalidInput with field, value and rule unless both are finite and above 0.
  void validate() const;

  /// [-] The part of the bound that is used up, of position or angle, whichever is more; above 1 it is passed.
  double used(const Divergence& divergence) const;
};

/// A movement or difference of a body below this counts as none: 1 mm, and for the tee's yaw what moves the end of the
/// stem by as much. It is a thirtieth of what the task tolerates, and a thousand times the offset of a floor's start.
constexpr Bound kNoticeable{0.001, 0.001 / (pusht::kStemOffset + pusht::kStemHalfLength)};

/// [m/s] A contact that slides faster than this on average over a control step is sliding. MuJoCo's soft contacts creep
/// while they stick, by 1 to 5 mm a control step. With this value sliding is where MuJoCo's friction is at its limit
/// for half of the step or more: the two agree in 94 % of the control steps in which the pusher stays on a box and
/// moves the tee (400 episodes of the shipped policy). With 0.01 m/s they would in 63 %.
constexpr double kSlidingSpeed = 0.05;

/// What happens in a control step. The first that applies; touching is that of pusht_task/contact.hpp, at the step's
/// start and end.
enum class Cause : std::size_t {
  kWall,            ///< pusher or tee touches a wall, at the start or the end
  kContactBegins,   ///< the pusher touches a box at the end that it did not touch at the start
  kContactEnds,     ///< the pusher touches the tee at the start, and no more at the end
  kCorner,          ///< the pusher sits in the corner of bar and stem throughout; it can hardly slide there
  kStickingOnBar,   ///< the pusher touches the bar throughout
  kSlidingOnBar,    ///< the same, faster than kSlidingSpeed
  kStickingOnStem,  ///< the pusher touches the stem throughout
  kSlidingOnStem,   ///< the same, faster than kSlidingSpeed
  kTeeAlone,        ///< the tee moves noticeably though the pusher touches it at neither end
  kFree,            ///< none of these: the pusher is on its way, or rests
};

/// Names of causes.
struct CauseName {
  Cause cause;
  const char* name;   ///< in files
  const char* label;  ///< for people
};

/// In the order of Cause.
inline constexpr std::array kCauses = {
    CauseName{Cause::kWall, "wall", "wall"},
    CauseName{Cause::kContactBegins, "contact_begins", "contact begins"},
    CauseName{Cause::kContactEnds, "contact_ends", "contact ends"},
    CauseName{Cause::kCorner, "corner", "in the corner"},
    CauseName{Cause::kStickingOnBar, "sticking_on_bar", "sticking on bar"},
    CauseName{Cause::kSlidingOnBar, "sliding_on_bar", "sliding on bar"},
    CauseName{Cause::kStickingOnStem, "sticking_on_stem", "sticking on stem"},
    CauseName{Cause::kSlidingOnStem, "sliding_on_stem", "sliding on stem"},
    CauseName{Cause::kTeeAlone, "tee_alone", "tee moves alone"},
    CauseName{Cause::kFree, "free", "free"},
};

constexpr const CauseName& nameOf(Cause cause) { return kCauses[static_cast<std::size_t>(cause)]; }

/// What happens in a control step, from the states before and after it.
/// Only the ends of a step are seen. So the tee moves alone where it coasts, where it is touched in between, and where
/// the simulator's bodies have other shapes than the task's.
Cause causeIn(const pusht::WorldState& before, const pusht::WorldState& after);

/// Which body was the first to be noticeably elsewhere.
enum class FirstBody : std::size_t {
  kPusher,
  kTee,
  kBoth,  ///< in the same control step
};

/// Names of FirstBody, in its order, for files and people.
inline constexpr std::array kFirstBodyNames = {"pusher", "tee", "both"};

constexpr const char* nameOf(FirstBody first) { return kFirstBodyNames[static_cast<std::size_t>(first)]; }

/// How two rollouts part.
struct FirstDivergence {
  int step;         ///< control steps taken when the divergence first is beyond the bound, from 1: an index of states
  Cause cause;      ///< what the reference did in the last of them
  FirstBody first;  ///< whose difference was the first to be noticeable (kNoticeable, or the bound where that is less)
};

/// When `other`, a rollout of the same episode, leaves the bound around `reference`; none if it stays within over the
/// steps that both have. The start is not looked at: it is the same, but for an offset of a floor's. Throws as
/// Bound::validate().
/// With the default bound this tells when it begins to matter, which is long after the first difference; with
/// kNoticeable, when and how that comes about.
std::optional<FirstDivergence> firstDivergenceOf(const pusht::Trace& reference, const pusht::Trace& other,
                                                 const Bound& bound = {});

/// [1/step] How fast a small difference grows: `other` is `reference` replayed in the same simulator from a start that
/// is moved a little, a floor. Above 0: it grows, by a factor of exp(rate) in a control step on average.
///
/// With u[k] = bound.used(divergence) after k steps, and K the first step at which u is beyond 1, else the last that
/// both have:
///   rate = ln(min(u[K], 1) / u[0]) / K.
/// It is the mean of the growth ln(u[k+1] / u[k]) of each step, cut where the bound is passed. Beyond, a difference
/// saturates: the tees cannot get farther apart than the table is wide.
/// Why not the slope of a least-squares line: differences grow in few steps, those with a push, and stay as they are
/// between. The line weighs a step by when it comes; the mean does not, and says by how much a difference has grown.
/// Source: E. Aurell et al., "Predictability in the Large" (1997), where a difference grows from one size to another.
///
/// NaN where there is none: no step; a start without difference, or beyond the bound. A difference that vanishes, bit
/// for bit, has no logarithm: the steps until then count, and if that is the first one the rate is NaN.
/// The start's offset must be well above the simulator's own resolution. MuJoCo finds contacts to 1e-6 m
/// (mpr_tolerance), so the first touch makes 1e-6 m of 1e-9 m, and that is no growth of the dynamics. From offsets of
/// 1e-6 m and of 1e-4 m the mean rates are alike, 0.032 and 0.035 per step; from 1e-9 m it is 0.098 (400 episodes of
/// the shipped policy).
/// Throws as Bound::validate().
double growthRate(const pusht::Trace& reference, const pusht::Trace& other, const Bound& bound = {});

}  // namespace sim2sim
