// SPDX-License-Identifier: BSD-3-Clause
#include "plan_policies.hpp"

#include <glob.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "plan_values.hpp"
#include "pusht_policy/checkpoint_home.hpp"
#include "pusht_policy/policy_choice.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "sim2sim_serving/installed_file.hpp"

namespace sim2sim {
namespace {

/// Names of the files that fit a pattern, in the order of their bytes, whatever the locale.
std::vector<std::string> filesLike(const std::string& pattern) {
  glob_t found{};
  std::vector<std::string> files;
  if (glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found) == 0) {
    files.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  }
  globfree(&found);
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::string> policiesNamed(const YAML::Node& node, const std::string& key) {
  const std::string text = textAt(node, key);
  std::error_code ignored;
  if (text.find_first_of("*?[") == std::string::npos || std::filesystem::exists(text, ignored)) {
    return {text};  // a file whose name has such a character is meant itself
  }
  std::vector<std::string> files = filesLike(text);
  if (files.empty()) {
    refuse(node, key, "no file is named like '" + text + "'; there must be one");
  }
  return files;
}

/// File of a policy; the installed one of the shipped policy.
std::filesystem::path fileOf(const std::string& policy) {
  const bool is_shipped = policy == pusht::kShippedPolicy;
  return is_shipped ? pusht::installedFile("pusht_policy", pusht::kShippedCheckpoint) : std::filesystem::path(policy);
}

/// Bytes that tell policies apart, as their digest; of a name without a file, and of a file that cannot be read, the
/// name.
std::string identityOf(const std::string& policy) {
  if (pusht::isWithoutFile(policy)) {
    return policy;
  }
  try {
    return pusht::sha256OfFile(fileOf(policy), "policy " + policy);
  } catch (const pusht::Error&) {  // loading it says why
    return policy;
  }
}

/// Refuses a policy that is in the list already, under another name too: a group would count it twice. The same bytes
/// beside another reference are another policy.
void requireNew(const YAML::Node& node, const PlannedPolicy& policy, const std::string& identity,
                const std::vector<PlannedPolicy>& before, const std::vector<std::string>& identities) {
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i].policy == policy.policy) {
      refuse(node, "policies", "'" + policy.policy + "' must appear only once");
    }
    if (identities[i] == identity && before[i].reference == policy.reference) {
      refuse(
          node, "policies",
          "'" + policy.policy + "' is '" + before[i].policy + "' under another name; a policy must appear only once");
    }
  }
}

/// What an entry of the list says of its policies.
struct ListEntry {
  std::vector<std::string> policies;
  std::string group;
  std::optional<SimulatorChoice> reference;  // none: the home of each
};

ListEntry entryIn(const YAML::Node& node, const std::optional<SimulatorChoice>& reference) {
  if (!node.IsMap()) {
    return {policiesNamed(node, "policies"), "", reference};
  }
  requireDistinctKeys(node);
  ListEntry entry{{}, "", reference};
  for (const auto& item : node) {
    const std::string key = textAt(item.first, "key");
    const YAML::Node& value = item.second;
    if (key == "files") {
      entry.policies = policiesNamed(value, key);
    } else if (key == "group") {
      entry.group = textAt(value, key);
    } else if (key == "reference") {
      entry.reference = textAt(value, key) == kHome ? std::nullopt : std::optional(simulatorAt(value, key));
    } else {
      refuse(item.first, key, "there is no such key; there are files, group, reference");
    }
  }
  if (entry.policies.empty()) {
    refuse(node, "policies", "must have files");
  }
  return entry;
}

/// Reference that a `policy` has if its reference is its home. Throws InvalidInput, naming the policy, if it has none.
SimulatorChoice homeOfPolicy(const std::string& policy) {
  if (pusht::isWithoutFile(policy)) {
    throw pusht::InvalidInput("policy " + policy + ": has no home; name its reference");
  }
  const pusht::CheckpointHome home = pusht::homeOf(fileOf(policy));
  return chooseSimulator(home.simulator, home.settings);
}

/// Policies that the `list` names, in its order; those of a pattern in the order of their names.
std::vector<PlannedPolicy> policiesIn(const YAML::Node& list, const std::optional<SimulatorChoice>& reference) {
  if (!list.IsSequence() || list.size() == 0) {
    refuse(list, "policies", "must be a list of policies");
  }
  std::vector<PlannedPolicy> policies;
  std::vector<std::string> identities;
  for (const YAML::Node& node : list) {
    const ListEntry entry = entryIn(node, reference);
    for (const std::string& policy : entry.policies) {
      std::optional<SimulatorChoice> own = entry.reference;
      if (!own) {
        inLineOf(node, [&] { own = homeOfPolicy(policy); });
      }
      PlannedPolicy planned{policy, entry.group, *own};
      std::string identity = identityOf(policy);
      requireNew(node, planned, identity, policies, identities);
      policies.push_back(std::move(planned));
      identities.push_back(std::move(identity));
    }
  }
  return policies;
}

}  // namespace

std::vector<PlannedPolicy> plannedPolicies(const YAML::Node& root, const std::optional<SimulatorChoice>& reference) {
  const YAML::Node one = root["policy"];
  if (const YAML::Node list = root["policies"]; list.IsDefined()) {
    if (one.IsDefined()) {
      refuse(one, "policy", "must not be there beside policies");
    }
    return policiesIn(list, reference);
  }
  const std::string policy = one.IsDefined() ? textAt(one, "policy") : pusht::kShippedPolicy;
  std::optional<SimulatorChoice> home = reference;
  if (!home) {
    inLineOf(root["reference"], [&] { home = homeOfPolicy(policy); });
  }
  return {{policy, "", *home}};
}

}  // namespace sim2sim
