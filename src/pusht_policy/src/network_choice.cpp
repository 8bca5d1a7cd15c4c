// SPDX-License-Identifier: BSD-3-Clause
#include "network_choice.hpp"

#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "pusht_policy/network_policy.hpp"
#include "pusht_task/files.hpp"

namespace pusht {
namespace {

/// Libraries that compute a network on libtorch, as far as they are loaded. A BLAS may have its code in a library
/// behind the one that libtorch calls.
const std::vector<std::string> kLibraries = {
    kNetworkPolicyLibrary, "libtorch_cpu.so", "libc10.so",  "libdnnl.so", "libsleef.so",
    "libXNNPACK.so",       "libgomp.so",      "libblas.so", "libblis",    "liblapack.so",
    "libopenblas",         "libatlas",        "libmkl"};

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
  addDescription(info.description, provenance);
  addNoise(info.description, provenance);
  return provenance;
}

/// Identity of a policy: all that its bits depend on, besides libraries. The kernel has equal bits everywhere, libtorch
/// does not. The BLAS is known by its bytes: another may have come under its name.
nlohmann::json identityOf(const NetworkInfo& info) {
  nlohmann::json identity = {{"sha256", info.sha256}};
  if (info.runsOnKernel()) {
    identity["operations"] = info.operations;
  } else {
    identity["libtorch"] = info.libtorch_version;
    identity["libtorch_choices"] = libtorchChoices();
    identity["blas"] = info.blas.empty() ? "" : sha256OfFile(info.blas, "BLAS");
  }
  addDescription(info.description, identity);
  return identity;
}

ChosenPolicy trained(const std::filesystem::path& path, const std::string& name, const std::function<bool()>& stop) {
  const std::shared_ptr<const NetworkPolicy> policy =
      NetworkPolicy::load(path, availableInstructionSets().back(), NetworkPolicy::kLoadDeadline, stop);
  const NetworkInfo& info = policy->info();
  ChosenPolicy chosen;
  chosen.make = [policy] { return policy->clone(); };
  chosen.name = name;
  chosen.identity = identityOf(info);
  chosen.provenance = provenanceOf(info);
  chosen.interface = info.description.interface;
  chosen.libraries = info.runsOnKernel() ? std::vector<std::string>{kNetworkPolicyLibrary} : kLibraries;
  return chosen;
}

ChosenPolicy untrained(std::uint64_t seed, const std::string& warning) {
  const std::shared_ptr<const NetworkPolicy> policy = NetworkPolicy::untrained(seed);
  const nlohmann::json identity = {{"untrained_seed", seed}, {"libtorch", policy->info().libtorch_version}};
  return {[policy] { return policy->clone(); }, kUntrainedPolicy,        identity,
          provenanceOf(policy->info()),         {kNetworkPolicyLibrary}, warning};
}

}  // namespace
}  // namespace pusht

extern "C" const pusht::NetworkPolicies kNetworkPolicies = {pusht::trained, pusht::untrained};
