// SPDX-License-Identifier: BSD-3-Clause
/// Trial of a network before it is used: what it must do with observations of episodes, and with others.
#pragma once

#include <string>
#include <vector>

#include "pusht_policy/network_kernel.hpp"
#include "pusht_policy/policy_description.hpp"
#include "torch_network.hpp"

namespace pusht {

/// Answers of `network` to the probes of its description, twice. `name` is for messages. Throws BadDependency if it
/// fails, an answer or state has another shape or is not finite, or the second answer to a probe is another one.
std::vector<float> tryOut(TorchNetwork& network, const std::string& name);

/// Throws UnfitForKernel unless the kernel answers the probes of a network without state and noise as libtorch did.
void requireAgreement(NetworkKernel& kernel, const PolicyDescription& description, const std::vector<float>& expected);

}  // namespace pusht
