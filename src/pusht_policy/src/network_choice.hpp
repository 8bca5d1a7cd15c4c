// SPDX-License-Identifier: BSD-3-Clause
/// The policies that need libtorch, in a library of their own. libtorch brings three hundred libraries with it, which
/// take a second to load: a command that runs none of these policies does without them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "pusht_policy/policy_choice.hpp"

namespace pusht {

constexpr const char* kNetworkPolicyLibrary = "libpusht_network_policy.so";
constexpr const char* kNetworkPoliciesSymbol = "kNetworkPolicies";

/// What that library offers, under the name kNetworkPoliciesSymbol.
struct NetworkPolicies {
  /// The checkpoint at `path`, by `name`. Throws as NetworkPolicy::load(), which heeds `stop`.
  ChosenPolicy (*trained)(const std::filesystem::path& path, const std::string& name,
                          const std::function<bool()>& stop);
  ChosenPolicy (*untrained)(std::uint64_t seed, const std::string& warning);
};

}  // namespace pusht

extern "C" const pusht::NetworkPolicies kNetworkPolicies;
