// SPDX-License-Identifier: BSD-3-Clause
/// How a closed loop ends, from its trace alone: so it is the same for every simulator, live, in batch and from a bag.
#pragma once

#include <array>
#include <cstddef>

#include "pusht_task/rollout.hpp"

namespace sim2sim {

/// [control steps] Time for which a body must have stayed where it ends to count as still: 5 s.
constexpr int kStillSteps = 50;

/// How a rollout ends; the first of the list that applies. A body stays where it ends if it is at most kNoticeable away
/// from there. A state beyond the plausible range, or not finite, is no ending: it fails the simulation.
enum class Ending : std::size_t {
  kSuccess,  ///< success latched
  kLost,     ///< the tee is off the table
  kStuck,    ///< the tee has been still for kStillSteps; if the pusher has, too, only noise can change anything
  kMoving,   ///< none of these; a rollout shorter than kStillSteps, too
};

/// Names of Ending, in its order, for files and people.
inline constexpr std::array kEndingNames = {"success", "lost", "stuck", "moving"};

/// What the pusher does at the end of a rollout; the first of the list that applies.
enum class PusherEnding : std::size_t {
  kLost,    ///< its center is off the table
  kStill,   ///< it has been still for kStillSteps
  kMoving,  ///< it moves
};

/// Names of PusherEnding, in its order, for files and people.
inline constexpr std::array kPusherEndingNames = {"lost", "still", "moving"};

/// End of a rollout.
struct RolloutEnding {
  Ending ending;
  int still_step;  ///< first control step from which on the tee stays where it ends; in [0, steps]
  PusherEnding pusher;
};

/// Name of an ending.
constexpr const char* nameOf(Ending ending) { return kEndingNames[static_cast<std::size_t>(ending)]; }

/// Name of what a pusher does.
constexpr const char* nameOf(PusherEnding pusher) { return kPusherEndingNames[static_cast<std::size_t>(pusher)]; }

/// End of a rollout that has ended.
RolloutEnding endingOf(const pusht::Rollout& rollout);

/// Whether the tee has left the table: its origin is beyond the inner face of a wall.
bool isOffTable(const pusht::WorldState& state, const pusht::Task& task = pusht::fullCircle());

}  // namespace sim2sim
