// SPDX-License-Identifier: BSD-3-Clause
/// Choice of a policy by its name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_task/policy.hpp"
#include "pusht_task/policy_interface.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

constexpr const char* kShippedPolicy = "bc";
/// Checkpoint that kShippedPolicy names, in this package's share.
constexpr const char* kShippedCheckpoint = "policies/bc_policy.ts.pt";
/// End of the name of a file that is read as ONNX; any other is TorchScript.
constexpr const char* kOnnxExtension = ".onnx";
constexpr const char* kExpertPolicy = "expert";
constexpr const char* kPlannerPolicy = "planner";
constexpr const char* kUntrainedPolicy = "fresh-untrained";

/// Whether a policy of that name is in no file.
bool isWithoutFile(const std::string& policy);

/// Parameters that choose a policy: the file or name, and what may replace a missing file.
struct PolicyChoice {
  std::string policy = kShippedPolicy;  ///< a TorchScript or ONNX file, or one of the names above
  bool require_policy = false;          ///< the shipped checkpoint must be there, too
  std::uint64_t untrained_seed = 0;     ///< seed of the weights of an untrained policy
  bool allow_untrained = false;         ///< an untrained policy replaces a named file that is not there
  std::reference_wrapper<const Task> task = fullCircle();  ///< what it is asked to do
};

/// Chosen policy: its factory, name, identity and provenance.
struct ChosenPolicy {
  std::function<std::unique_ptr<Policy>()> make;  ///< makes a policy for one more thread; not thread-safe
  std::string name;                               ///< as given, or "fresh-untrained"
  nlohmann::json identity;             ///< policies with equal identities, run by equal code, have equal bits
  nlohmann::json provenance;           ///< origin, and what it runs on
  std::vector<std::string> libraries;  ///< prefixes of the names of libraries that compute it, besides pusht_policy
  std::string warning;                 ///< says that another policy runs than was asked for; else empty
  PolicyInterface interface {};        ///< what it sees
};

/// Loads the policy of `choice`. `shipped` is the checkpoint that "bc" names. If it is not there, an untrained policy
/// runs, with a warning, unless `choice` requires it: the course's guard. A named file must be there. Throws
/// InvalidInput for a policy whose interface does not fit the task; as NetworkPolicy::load(), which gets `stop`, or as
/// OnnxPolicy::load(); BadDependency if the library that this takes, of networks or of ONNX, is not beside this one, or
/// if the kind in which "planner" plans is not built: gym_pusht in its task, rigid_body in any other.
ChosenPolicy choosePolicy(
    const PolicyChoice& choice, const std::filesystem::path& shipped,
    const std::function<bool()>& stop = [] { return false; });

}  // namespace pusht
