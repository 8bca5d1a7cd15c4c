// SPDX-License-Identifier: BSD-3-Clause
/// Coverage of intervals of divergences of which few are large, on the episodes of real runs.
#pragma once

#include "simulation.hpp"

namespace sim2sim {

/// Prints tables of means, ratios and paired differences, each with its coverage and its median interval.
void tails(Simulation& simulation);

}  // namespace sim2sim
