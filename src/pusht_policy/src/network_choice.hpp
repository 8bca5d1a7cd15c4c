// SPDX-License-Identifier: BSD-3-Clause
/// Policies that need libtorch or ONNX, each in a library of its own, which is loaded on demand. libtorch depends on
/// three hundred libraries, which take a second to load, and a command with another policy does not need them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "pusht_policy/policy_choice.hpp"

namespace pusht {

constexpr const char* kNetworkPolicyLibrary = "libpusht_network_policy.so";
constexpr const char* kNetworkPoliciesSymbol = "kNetworkPolicies";

/// Functions of that library, under the symbol kNetworkPoliciesSymbol.
struct NetworkPolicies {
  /// Policy of the checkpoint at `path`, named `name`. Throws as NetworkPolicy::load(), which gets `stop`.
  ChosenPolicy (*trained)(const std::filesystem::path& path, const std::string& name,
                          const std::function<bool()>& stop);
  ChosenPolicy (*untrained)(std::uint64_t seed, const std::string& warning);
};

constexpr const char* kOnnxPolicyLibrary = "libpusht_onnx_policy.so";
constexpr const char* kOnnxPoliciesSymbol = "kOnnxPolicies";

/// Functions of that library, under the symbol kOnnxPoliciesSymbol.
struct OnnxPolicies {
  /// Policy of the ONNX file at `path`, named `name`. Throws as OnnxPolicy::load().
  ChosenPolicy (*trained)(const std::filesystem::path& path, const std::string& name);
};

}  // namespace pusht

extern "C" const pusht::NetworkPolicies kNetworkPolicies;
extern "C" const pusht::OnnxPolicies kOnnxPolicies;
