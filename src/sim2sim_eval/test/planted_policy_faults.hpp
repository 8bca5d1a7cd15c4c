// SPDX-License-Identifier: BSD-3-Clause
/// Faults that are planted in policies, and the words by which an audit must name each.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pusht_task/policy.hpp"
#include "sim2sim_audit/policy_audit.hpp"

namespace sim2sim::testing {

/// Fault of a policy's interface.
struct PolicyFault {
  std::string name;
  std::string named_by;  ///< beginning of the words of the correction that names it
  std::function<pusht::Observation(pusht::Observation)> observation{};
  std::function<std::vector<pusht::Observation>(std::vector<pusht::Observation>)> history{};
  std::function<pusht::Action(pusht::Action, const pusht::Observation&)> action{};
  std::function<std::vector<pusht::Action>(std::vector<pusht::Action>)> chunk{};
  int delay = 0;  ///< control steps by which an action comes late

  bool fits(const PolicySignature& signature) const {
    return (!history || (signature.observations > 1 && !signature.has_state)) && (!chunk || signature.actions > 1);
  }
};

/// Single faults. Those of normalization are by the numbers of `trained_on`.
std::vector<PolicyFault> plantedPolicyFaults(const std::vector<Demonstration>& trained_on);

/// Policy with faults, the first one next to the world. `policy` must outlive it.
std::unique_ptr<pusht::Policy> faulty(pusht::Policy& policy, const PolicySignature& signature,
                                      const std::vector<PolicyFault>& faults);

}  // namespace sim2sim::testing
