// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/policy_choice.hpp"

#include <system_error>
#include <utility>
#include <vector>

#include "pusht_policy/network_policy.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/files.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;

/// What libtorch computes with, as far as that is loaded. A BLAS may have its code in a library behind the one that
/// libtorch calls.
const std::vector<std::string> kLibtorchLibraries = {"libtorch_cpu.so", "libc10.so",   "libdnnl.so", "libsleef.so",
                                                     "libXNNPACK.so",   "libgomp.so",  "libblas.so", "libblis",
                                                     "liblapack.so",    "libopenblas", "libatlas",   "libmkl"};

nlohmann::json provenanceOf(const NetworkInfo& info) {
  nlohmann::json provenance = {{"sha256", info.sha256},
                               {"runs_on", info.runsOnKernel() ? "fixed-order kernel" : "libtorch"},
                               {"libtorch", info.libtorch_version},
                               {"blas", info.blas}};
  if (info.runsOnKernel()) {
    provenance["operations"] = info.operations;
    provenance["instruction_set"] = info.instruction_set;
  } else {
    provenance["libtorch_choices"] = libtorchChoices();
    provenance["note"] = "the bits of this run depend on the BLAS; not on the kernel: " + info.why_not_on_kernel;
  }
  return provenance;
}

/// What its bits depend on, besides libraries: the kernel computes the same everywhere, libtorch does not. The BLAS is
/// known by its bytes: another may have come under its name.
nlohmann::json identityOf(const NetworkInfo& info) {
  if (info.runsOnKernel()) {
    return {{"sha256", info.sha256}, {"operations", info.operations}};
  }
  return {{"sha256", info.sha256},
          {"libtorch", info.libtorch_version},
          {"libtorch_choices", libtorchChoices()},
          {"blas", info.blas.empty() ? "" : sha256(readFile(info.blas, "BLAS"))}};
}

ChosenPolicy trained(const fs::path& path, const std::string& name, const std::function<bool()>& stop) {
  const std::shared_ptr<const NetworkPolicy> policy =
      NetworkPolicy::load(path, availableInstructionSets().back(), NetworkPolicy::kLoadDeadline, stop);
  return {[policy] { return policy->clone(); },
          name,
          identityOf(policy->info()),
          provenanceOf(policy->info()),
          policy->info().runsOnKernel() ? std::vector<std::string>() : kLibtorchLibraries,
          ""};
}

ChosenPolicy untrained(std::uint64_t seed, const std::string& warning = "") {
  const std::shared_ptr<const NetworkPolicy> policy = NetworkPolicy::untrained(seed);
  const nlohmann::json identity = {{"untrained_seed", seed}, {"libtorch", policy->info().libtorch_version}};
  return {[policy] { return policy->clone(); }, kUntrainedPolicy, identity, provenanceOf(policy->info()), {}, warning};
}

}  // namespace

ChosenPolicy choosePolicy(const PolicyChoice& choice, const fs::path& shipped, const std::function<bool()>& stop) {
  if (choice.policy == kExpertPolicy) {
    return {[] { return std::make_unique<ScriptedExpert>(); },
            kExpertPolicy,
            {{"scripted", kExpertPolicy}},
            {{"runs_on", "scripted"}},
            {},
            ""};
  }
  if (choice.policy == kUntrainedPolicy) {
    return untrained(choice.untrained_seed);
  }
  if (choice.policy == kShippedPolicy) {
    return trained(shipped, kShippedPolicy, stop);
  }
  std::error_code ignored;
  const bool missing = fs::status(choice.policy, ignored).type() == fs::file_type::not_found;
  if (choice.require_policy || choice.policy.empty() || !missing) {
    return trained(choice.policy, choice.policy, stop);
  }
  // The course's guard, the one place where a measurement goes on with something else than was asked for.
  return untrained(choice.untrained_seed,
                   "policy " + choice.policy +
                       ": there is no such file. Running an UNTRAINED policy instead: success and transfer say nothing "
                       "until a trained one is named.");
}

}  // namespace pusht
