// SPDX-License-Identifier: BSD-3-Clause
/// Coverage of intervals over policies and initial states at once, with planted variances.
#pragma once

#include "simulation.hpp"

namespace sim2sim {

/// Prints tables of success rates, their differences and their ratios.
void crossed(Simulation& simulation);

}  // namespace sim2sim
