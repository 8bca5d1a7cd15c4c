// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/policy_choice.hpp"

#include <boost/dll/runtime_symbol_info.hpp>
#include <boost/dll/shared_library.hpp>
#include <system_error>

#include "network_choice.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;

const NetworkPolicies& loadNetworkPolicies() {
  const fs::path path = fs::path(boost::dll::this_line_location().string()).replace_filename(kNetworkPolicyLibrary);
  try {
    namespace mode = boost::dll::load_mode;
    // Global, so that it can be asked which BLAS there is. Never freed: its policies may live until the program ends.
    static const auto& library = *new boost::dll::shared_library(path.string(), mode::rtld_now | mode::rtld_global);
    return library.get<const NetworkPolicies>(kNetworkPoliciesSymbol);
  } catch (const boost::system::system_error& error) {
    throw BadDependency("library " + path.string() + ": cannot be loaded: " + error.what());
  }
}

const NetworkPolicies& networkPolicies() {
  static const NetworkPolicies& policies = loadNetworkPolicies();
  return policies;
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
    return networkPolicies().untrained(choice.untrained_seed, "");
  }
  if (choice.policy == kShippedPolicy) {
    return networkPolicies().trained(shipped, kShippedPolicy, stop);
  }
  std::error_code ignored;
  const bool missing = fs::status(choice.policy, ignored).type() == fs::file_type::not_found;
  if (choice.require_policy || choice.policy.empty() || !missing) {
    return networkPolicies().trained(choice.policy, choice.policy, stop);
  }
  // The course's guard, the one place where a measurement goes on with something else than was asked for.
  return networkPolicies().untrained(
      choice.untrained_seed,
      "policy " + choice.policy +
          ": there is no such file. Running an UNTRAINED policy instead: success and transfer say nothing "
          "until a trained one is named.");
}

}  // namespace pusht
