// SPDX-License-Identifier: BSD-3-Clause
/// Coverage of the interval of an equivalent error, with planted sizes.
#pragma once

#include "simulation.hpp"

namespace sim2sim {

/// Prints a table of planted sizes: at a size that was tried, between two, and with engines that fail in the same or in
/// other starts.
void equivalents(Simulation& simulation);

}  // namespace sim2sim
