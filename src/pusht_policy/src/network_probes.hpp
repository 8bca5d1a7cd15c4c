// SPDX-License-Identifier: BSD-3-Clause
/// Observations with which a network is tried out when it is loaded.
#pragma once

#include <vector>

#include "pusht_task/policy_interface.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

constexpr int kNetworkProbes = 64;

/// Probes, kNetworkProbes of them: starts of episodes, and some observations that no episode shows; those of gym-pusht
/// for an interface that is its.
std::vector<Observation> networkProbes(const PolicyInterface& interface);

}  // namespace pusht
