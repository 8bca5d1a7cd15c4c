// SPDX-License-Identifier: BSD-3-Clause
/// First divergence of two rollouts of an episode (step and cause), and the growth rate of small differences. All of it
/// is computed from traces, so it is the same for every simulator, live, in batch and from a bag.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "pusht_task/constants.hpp"
#include "pusht_task/rollout.hpp"
#include "sim2sim_protocol/divergence.hpp"

namespace sim2sim {

/// Largest divergence of two tees that still counts as none. The default is the tolerance of the task itself.
struct Bound {
  double position = pusht::kPositionTolerance;  ///< [m]
  double angle = pusht::kAngleTolerance;        ///< [rad]

  /// Throws InvalidInput with field, value and rule unless both are finite and above 0.
  void validate() const;

  /// [-] Divergence as a multiple of the bound, in position or angle, whichever is larger. Above 1 it is passed.
  double used(const Divergence& divergence) const;
};

/// Smallest movement or difference of a body that counts: 1 mm, and for the tee's yaw the angle that moves the end of
/// the stem by as much. It is a thirtieth of the task's tolerance, and a thousand times the offset of a floor.
constexpr Bound kNoticeable{0.001, 0.001 / (pusht::kStemOffset + pusht::kStemHalfLength)};

/// [m/s] Slip speed, averaged over a control step, from which on a contact counts as sliding. MuJoCo's soft contacts
/// creep while they stick, by 1 to 5 mm a control step. With this value, sliding agrees with MuJoCo's Coulomb friction
/// being at its limit for at least half of the step in 94 % of the control steps in which the pusher stays on a box and
/// moves the tee (400 episodes of the shipped policy); with 0.01 m/s it agrees in 63 %.
constexpr double kSlidingSpeed = 0.05;

/// Event of a control step; the first of the list that applies. Contacts are those of pusht_task/contact.hpp, at the
/// start and the end of the step.
enum class Cause : std::size_t {
  kWall,            ///< pusher or tee touches a wall, at the start or the end
  kContactBegins,   ///< the pusher touches the tee at the end, but neither box at both the start and the end
  kContactEnds,     ///< the pusher touches the tee at the start, and no more at the end
  kCorner,          ///< the pusher touches bar and stem at the start and the end; it can hardly slide in that corner
  kStickingOnBar,   ///< the pusher touches the bar at the start and the end, and slides at most at kSlidingSpeed
  kSlidingOnBar,    ///< the pusher touches the bar at the start and the end, and slides faster
  kStickingOnStem,  ///< the pusher touches the stem at the start and the end, and slides at most at kSlidingSpeed
  kSlidingOnStem,   ///< the pusher touches the stem at the start and the end, and slides faster
  kTeeAlone,        ///< the tee moves noticeably though the pusher touches it at neither end
  kFree,            ///< none of these: the pusher is on its way, or rests
};

/// Names of causes.
struct CauseName {
  Cause cause;
  const char* name;   ///< in files
  const char* label;  ///< for people
};

/// Names of all causes, in the order of Cause.
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

/// Names of a cause, for files and people.
constexpr const CauseName& nameOf(Cause cause) { return kCauses[static_cast<std::size_t>(cause)]; }

/// Classifies a control step by the states before and after it. Contacts within the step are not seen. So the tee moves
/// alone (kTeeAlone) if it coasts, if it is touched in between, or if the simulator's bodies have other shapes than the
/// task's.
Cause causeIn(const pusht::WorldState& before, const pusht::WorldState& after,
              const pusht::Task& task = pusht::fullCircle());

/// Body that differs noticeably first.
enum class FirstBody : std::size_t {
  kPusher,
  kTee,
  kBoth,  ///< in the same control step
};

/// Names of FirstBody, in its order, for files and people.
inline constexpr std::array kFirstBodyNames = {"pusher", "tee", "both"};

/// Name of the body that differs first.
constexpr const char* nameOf(FirstBody first) { return kFirstBodyNames[static_cast<std::size_t>(first)]; }

/// Step and cause at which a rollout leaves the bound around the reference.
struct FirstDivergence {
  int step;         ///< control steps taken when the divergence first passes the bound; >= 1, an index of states
  Cause cause;      ///< event in the reference in the last of these steps
  FirstBody first;  ///< body that differed first by more than kNoticeable, or than the bound if that is less
};

/// First divergence of `other`, a rollout of the same episode, from `reference`. Empty if it stays within the bound
/// over the steps that both have. The initial state is left out: it is equal, but for the offset of a floor. Throws
/// InvalidInput as Bound::validate().
/// With the default bound, this is when the difference begins to matter for the task, long after the first difference.
/// With kNoticeable, it is when and how the first difference comes about.
std::optional<FirstDivergence> firstDivergenceOf(const pusht::Trace& reference, const pusht::Trace& other,
                                                 const Bound& bound = {},
                                                 const pusht::Task& task = pusht::fullCircle());

/// [1/control step] Growth rate of a small difference. `other` is `reference` replayed in the same simulator from a
/// slightly moved initial state (a floor). Above 0 the difference grows, by a factor of exp(rate) per step on average.
///
/// With u[k] = bound.used(divergence) after k steps, and K the first step at which u is beyond 1, else the last that
/// both have:
///   rate = ln(min(u[K], 1) / u[0]) / K.
/// This is the mean over steps of ln(u[k+1] / u[k]), cut where the bound is passed. Beyond the bound a difference
/// saturates: the tees cannot get farther apart than the table is wide.
/// The slope of a least-squares line would depend on when the growth happens: differences grow in the few steps with a
/// push and stay as they are in between, and a line weighs a step by its time. The mean does not.
/// Source: E. Aurell et al., "Predictability in the Large" (1997), where a difference grows from one size to another.
///
/// NaN if there is no step, or if the initial difference is 0 or beyond the bound. A difference that vanishes bit for
/// bit has no logarithm: only the steps before count, and if there are none the rate is NaN.
/// The initial offset must be well above the simulator's own resolution. MuJoCo finds contacts to 1e-6 m
/// (mpr_tolerance), so the first touch turns 1e-9 m into 1e-6 m, which is no growth of the dynamics. From offsets of
/// 1e-6 m and of 1e-4 m the mean rates are alike, 0.032 and 0.035 per step; from 1e-9 m it is 0.098 (400 episodes of
/// the shipped policy).
/// Throws InvalidInput as Bound::validate().
double growthRate(const pusht::Trace& reference, const pusht::Trace& other, const Bound& bound = {});

}  // namespace sim2sim
