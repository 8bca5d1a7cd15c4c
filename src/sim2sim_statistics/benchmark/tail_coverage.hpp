// SPDX-License-Identifier: BSD-3-Clause
/// Coverage of intervals of divergences of which few are large, on the episodes of real runs.
#pragma once

#include <vector>

#include "known_truths.hpp"
#include "simulation.hpp"

namespace sim2sim {

/// Prints tables of means, ratios and paired differences, each with its coverage and its median interval.
void tails(Simulation& simulation);

/// Position divergences [m] of the engines, resampled from real episodes: few of one carry its mean, of the next fewer
/// do.
std::vector<Population> measuredPositions();

}  // namespace sim2sim
