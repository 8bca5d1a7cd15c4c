// SPDX-License-Identifier: BSD-3-Clause
/// Coverage of intervals of rank correlations between two simulators, with planted correlations.
#pragma once

#include "simulation.hpp"

namespace sim2sim {

/// Prints tables of correlations, the rank violation and the agreement of pairs, how often there is no interval, and
/// how often rankings that are not there are found.
void rankings(Simulation& simulation);

}  // namespace sim2sim
