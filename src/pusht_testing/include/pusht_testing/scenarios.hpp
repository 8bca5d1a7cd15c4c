// SPDX-License-Identifier: BSD-3-Clause
/// Starts and actions that put a world under load, for tests and benchmarks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pusht_task/task.hpp"
#include "pusht_task/types.hpp"

namespace pusht::testing {

/// A spawn that moves and turns, as no episode starts but a world may be set to.
WorldState movingState(std::uint64_t seed);

/// Starts that are allowed, and that no simulation can make sense of: too fast for a table, one body inside the other,
/// in walls and far beyond them.
std::vector<WorldState> absurdStates();

/// Starts that are not allowed.
std::array<WorldState, 4> statesBeyondWhatIsPlausible();

/// Drives the pusher at the tee and through it, so that there is contact: reaction, not memory.
Action chase(const WorldState& state, const Task& task = fullCircle());

/// Actions for the worlds of a batch: most chase, so that contacts come and go; every fourth pushes straight on, and
/// now and then the pusher is told to stand still.
Action mixedAction(const WorldState& state, std::size_t world, int step);

}  // namespace pusht::testing
