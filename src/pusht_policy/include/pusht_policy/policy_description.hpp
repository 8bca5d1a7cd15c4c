// SPDX-License-Identifier: BSD-3-Clause
/// Description of a network: what it looks back on, how many actions it answers with, its state and its noise.
/// docs/policies.md says how a checkpoint carries one.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_task/policy_interface.hpp"

namespace pusht {

/// Extra file of a TorchScript archive that has the description.
constexpr const char* kDescriptionFile = "policy.json";

/// Signature of a network, and how its answers are used. The default is the plain contract: one observation, one
/// action, no state, no noise.
struct PolicyDescription {
  /// Distribution of each number of the noise: standard normal, or uniform on [0, 1).
  enum class Distribution { kNormal, kUniform };
  using Shape = std::vector<int>;  ///< sizes for one rollout; empty: the network has none

  // Limits of a description. A policy node keeps the memory of a thousand rollouts.
  static constexpr int kMostObservations = 1000;
  static constexpr int kMostActions = 1000;
  static constexpr int kMostNumbers = 65'536;  ///< values of a state, and of a noise
  static constexpr int kMostDimensions = 8;

  PolicyInterface interface {};  ///< what an observation is to the network
  bool described = false;  ///< false: no description; the network maps [1, 10] to [1, 2], without dimensions of time
  int observations = 1;    ///< observations that the network gets at each call: the latest ones, the oldest first
  int actions = 1;         ///< actions of an answer
  int execute = 1;         ///< actions that are executed before the network is asked again
  Shape state{};           ///< goes in and comes out at each call; zeros at the beginning of a rollout
  Shape noise{};           ///< drawn for each call
  Distribution distribution = Distribution::kNormal;

  bool isStochastic() const { return !noise.empty(); }
  /// Whether a rollout must remember anything from one control step to the next.
  bool hasMemory() const { return observations > 1 || actions > 1 || !state.empty() || !noise.empty(); }

  /// Shapes of a call for one rollout, with its leading 1: "float [1, 2, 10], state float [1, 64]".
  std::string inputs() const;
  std::string outputs() const;
};

/// Number of values in a shape; 0 if there is none.
std::size_t numbersIn(const PolicyDescription::Shape& shape);

/// Reads a description, JSON. `where` begins messages: "policy FILE: policy.json". Throws InvalidInput, naming key,
/// value and rule, if it is no JSON, a key is missing, unknown or there twice, or a value breaks its rule.
PolicyDescription descriptionFrom(const std::string& text, const std::string& where);

/// Description as written in a file, with all defaults.
nlohmann::json toJson(const PolicyDescription& description);

/// Adds the description of a network that has one, as "description", to the provenance or the identity of a policy.
void addDescription(const PolicyDescription& description, nlohmann::json& object);

/// Adds to a provenance where the noise of a network comes from, if it takes any.
void addNoise(const PolicyDescription& description, nlohmann::json& provenance);

}  // namespace pusht
