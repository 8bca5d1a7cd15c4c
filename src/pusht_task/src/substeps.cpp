// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/substeps.hpp"

#include <cmath>

#include "pusht_task/constants.hpp"

namespace pusht {

ParameterDescriptor substepDescriptor(const char* name) {
  ParameterDescriptor descriptor{name, "s", "length of a substep", kSubstep};
  for (const int divisor : {1, 2, 5, 10, 20}) {
    descriptor.numbers.push_back(kSubstep / divisor);
  }
  descriptor.least = descriptor.numbers.back();
  descriptor.greatest = descriptor.numbers.front();
  descriptor.reason = "0.01 divided by 1, 2, 5, 10 or 20";
  return descriptor;
}

int substepsPerControlStep(double substep) { return static_cast<int>(std::lround(kControlStep / substep)); }

}  // namespace pusht
