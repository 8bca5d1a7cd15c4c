// SPDX-License-Identifier: BSD-3-Clause
/// Coverage of the difference of two transfers: two policies from the same starts in the same two simulators.
#pragma once

#include "simulation.hpp"

namespace sim2sim {

/// Prints tables of the interval of the difference, and of its test.
void transferDifferences(Simulation& simulation);

}  // namespace sim2sim
