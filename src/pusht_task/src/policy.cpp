// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/policy.hpp"

#include <string>

#include "pusht_task/error.hpp"

namespace pusht {

std::unique_ptr<Policy::Memory> Policy::begin(const Beginning& beginning) const {
  requireExecutable(beginning, 1);
  return nullptr;
}

void Policy::requireExecutable(const Beginning& beginning, int answered) {
  if (beginning.execute < 0 || beginning.execute > answered) {
    throw InvalidInput("execute " + std::to_string(beginning.execute) + ": must be from 1 to " +
                       std::to_string(answered) + ", the actions of an answer of the policy; 0: as many as it says");
  }
}

}  // namespace pusht
