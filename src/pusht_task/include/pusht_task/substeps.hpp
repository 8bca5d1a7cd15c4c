// SPDX-License-Identifier: BSD-3-Clause
/// Substeps of another length than kSubstep, for kinds whose discretization is a parameter.
#pragma once

#include "pusht_task/parameters.hpp"

namespace pusht {

/// Descriptor of a kind's length of a substep [s]: kSubstep, or kSubstep divided by 2, 5, 10 or 20, so that a control
/// step has a whole number of them.
ParameterDescriptor substepDescriptor(const char* name);

/// Number of substeps of this length [s] in a control step; `substep` is a value of substepDescriptor().
int substepsPerControlStep(double substep);

}  // namespace pusht
