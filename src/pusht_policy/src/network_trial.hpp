// SPDX-License-Identifier: BSD-3-Clause
/// Trial of a network before it is used: what it must do with observations of episodes, and with others.
#pragma once

#include <string>
#include <vector>

#include "network_actor.hpp"
#include "pusht_policy/policy_description.hpp"

namespace pusht {

/// Answers of `network` to the probes of its description. `name` is for messages. Throws BadDependency if an answer or
/// a state is not finite, and what the network throws.
std::vector<float> answersToProbes(Network& network, const PolicyDescription& description, const std::string& name);

/// Throws UnfitForKernel unless the kernel answers the probes as libtorch did.
void requireAgreement(const std::vector<float>& actual, const std::vector<float>& expected,
                      const PolicyInterface& interface);

}  // namespace pusht
