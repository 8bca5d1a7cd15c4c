// SPDX-License-Identifier: BSD-3-Clause
/// A policy by its name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_task/policy.hpp"

namespace pusht {

constexpr const char* kShippedPolicy = "bc";
constexpr const char* kExpertPolicy = "expert";
constexpr const char* kUntrainedPolicy = "fresh-untrained";

/// Parameters that choose a policy: the file or name, and what may replace a missing file.
struct PolicyChoice {
  std::string policy = kShippedPolicy;  ///< a TorchScript file, or one of the names above
  bool require_policy = false;          ///< the shipped checkpoint must be there, too
  std::uint64_t untrained_seed = 0;     ///< of the weights, where an untrained policy runs
  bool allow_untrained = false;         ///< an untrained policy replaces a named file that is not there
};

/// Chosen policy: its factory, name, identity and provenance.
struct ChosenPolicy {
  std::function<std::unique_ptr<Policy>()> make;  ///< the policy, for one thread after the other
  std::string name;                               ///< the string given, or "fresh-untrained"
  nlohmann::json identity;    ///< two policies with the same one, run by the same code, act the same, bit by bit
  nlohmann::json provenance;  ///< where it comes from and what it runs on
  std::vector<std::string> libraries;  ///< begin the names of those that compute it, besides pusht_policy, if loaded
  std::string warning;                 ///< says that something else runs than was asked for; else empty
};

/// `shipped` is the checkpoint that "bc" names. If it is not there, an untrained policy runs, with a warning, unless
/// `choice` requires it: the course's guard. A file that is named must be there. Throws as NetworkPolicy::load does,
/// which heeds `stop`; and BadDependency if the library of the networks, which is loaded for all but the expert, is not
/// beside this one.
ChosenPolicy choosePolicy(
    const PolicyChoice& choice, const std::filesystem::path& shipped,
    const std::function<bool()>& stop = [] { return false; });

}  // namespace pusht
