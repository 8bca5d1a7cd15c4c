// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/policy_choice.hpp"

#include <system_error>
#include <utility>

#include "pusht_policy/network_policy.hpp"
#include "pusht_policy/scripted_expert.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;

nlohmann::json provenanceOf(const NetworkInfo& info) {
  nlohmann::json provenance = {{"sha256", info.sha256},
                               {"runs_on", info.runsOnKernel() ? "fixed-order kernel" : "libtorch"},
                               {"libtorch", info.libtorch_version},
                               {"blas", info.blas}};
  if (info.runsOnKernel()) {
    provenance["operations"] = info.operations;
    provenance["instruction_set"] = info.instruction_set;
  } else {
    provenance["note"] = "the bits of this run depend on the BLAS; not on the kernel: " + info.why_not_on_kernel;
  }
  return provenance;
}

ChosenPolicy network(std::unique_ptr<NetworkPolicy> policy, const std::string& name, const std::string& warning = "") {
  nlohmann::json provenance = provenanceOf(policy->info());
  return {std::move(policy), name, std::move(provenance), warning};
}

}  // namespace

ChosenPolicy choosePolicy(const PolicyChoice& choice, const fs::path& shipped) {
  if (choice.policy == kExpertPolicy) {
    return {std::make_unique<ScriptedExpert>(), kExpertPolicy, {{"runs_on", "scripted"}}, ""};
  }
  if (choice.policy == kUntrainedPolicy) {
    return network(NetworkPolicy::untrained(choice.untrained_seed), kUntrainedPolicy);
  }
  if (choice.policy == kShippedPolicy) {
    return network(NetworkPolicy::load(shipped), kShippedPolicy);
  }
  std::error_code ignored;
  const bool missing = fs::status(choice.policy, ignored).type() == fs::file_type::not_found;
  if (choice.require_policy || choice.policy.empty() || !missing) {
    return network(NetworkPolicy::load(choice.policy), choice.policy);
  }
  // The course's guard, the one place where a measurement goes on with something else than was asked for.
  return network(NetworkPolicy::untrained(choice.untrained_seed), kUntrainedPolicy,
                 "policy " + choice.policy +
                     ": there is no such file. Running an UNTRAINED policy instead: success and transfer say nothing "
                     "until a trained one is named.");
}

}  // namespace pusht
