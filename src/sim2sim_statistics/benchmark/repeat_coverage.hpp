// SPDX-License-Identifier: BSD-3-Clause
/// Coverage of intervals over starts that are repeated with other noise, with planted variances.
#pragma once

#include "simulation.hpp"

namespace sim2sim {

/// Prints tables of success rates, their differences, their ratios and the two parts of their variance, of mean
/// divergences, and of what intervals over episodes would hold.
void repeats(Simulation& simulation);

}  // namespace sim2sim
