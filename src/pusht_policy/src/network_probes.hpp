// SPDX-License-Identifier: BSD-3-Clause
/// Observations with which a network is tried out when it is loaded.
#pragma once

#include <vector>

#include "pusht_task/types.hpp"

namespace pusht {

constexpr int kNetworkProbes = 64;

/// Probes, kNetworkProbes of them: starts of episodes, and some observations that no episode shows.
std::vector<Observation> networkProbes();

}  // namespace pusht
