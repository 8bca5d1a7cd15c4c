// SPDX-License-Identifier: BSD-3-Clause
// Whether an audit of a policy tells the truth: faults are planted in the shipped policies, and it must name them; where
// there is none, it must find none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <set>
#include <string>
#include <vector>

#include "planted_policy_faults.hpp"
#include "pusht_mujoco/mujoco_kind.hpp"
#include "pusht_policy/policy_choice.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "pusht_testing/long_tests.hpp"
#include "sim2sim_eval/policy_audit_run.hpp"
#include "sim2sim_serving/installed_file.hpp"

namespace sim2sim::testing {
namespace {

using ::testing::IsEmpty;

/// Demonstrations of the expert in MuJoCo from spawn seeds on.
std::vector<Demonstration> demonstrationsOfTheExpert(std::uint64_t seed, int episodes) {
  const std::unique_ptr<pusht::Simulator> world =
      pusht::mujocoKind().load(pusht::mujocoKind().defaults()).make_world();
  pusht::ScriptedExpert expert;
  std::vector<Demonstration> demonstrations;
  for (int i = 0; i < episodes; ++i) {
    const pusht::Rollout rollout =
        pusht::runClosedLoop(*world, pusht::spawn(seed + static_cast<std::uint64_t>(i)), expert, pusht::kHorizon);
    const pusht::Trace& trace = rollout.trace();
    demonstrations.emplace_back();
    for (std::size_t step = 0; step < trace.steps(); ++step) {
      demonstrations.back().observations.push_back(pusht::observe(trace.states[step]));
      demonstrations.back().actions.push_back(trace.actions[step]);
    }
  }
  return demonstrations;
}

const std::vector<Demonstration>& heldDemonstrations() {
  static const std::vector<Demonstration> demonstrations = demonstrationsOfTheExpert(20'000, 40);
  return demonstrations;
}

/// Demonstrations that a wrapper takes its normalization from.
const std::vector<Demonstration>& otherDemonstrations() {
  static const std::vector<Demonstration> demonstrations = demonstrationsOfTheExpert(500, 60);
  return demonstrations;
}

/// A shipped policy, as one of a kind.
struct Shipped {
  std::string kind;
  std::string file;
  int actions = 0;  ///< of an answer that are used; 0: all
};

const std::vector<Shipped>& shippedPolicies() {
  static const std::vector<Shipped> policies = {{"plain", "policies/bc_policy.ts.pt"},
                                                {"history", "policies/chunk.ts.pt", 1},
                                                {"chunks", "policies/chunk.ts.pt"},
                                                {"state", "policies/gru.ts.pt"},
                                                {"noise", "policies/flow.ts.pt"}};
  return policies;
}

/// A loaded policy with its signature.
struct Loaded {
  explicit Loaded(const Shipped& shipped) : kind(shipped.kind) {
    const std::string file = pusht::installedFile("pusht_policy", shipped.file);
    const pusht::ChosenPolicy chosen = pusht::choosePolicy({file, true}, file);
    signature = signatureOf(chosen);
    signature.actions = shipped.actions > 0 ? shipped.actions : signature.actions;
    policy = chosen.make();
  }

  PolicyAudit audit(const std::vector<PolicyFault>& faults) const {
    const std::unique_ptr<pusht::Policy> wrapped = faulty(*policy, signature, faults);
    return auditPolicy(*wrapped, signature, heldDemonstrations());
  }

  std::string kind;
  PolicySignature signature;
  std::unique_ptr<pusht::Policy> policy;
};

/// Whether the audit names these faults: one of the explanations that it gives has a correction of each, and no other.
bool names(const PolicyAudit& audit, const std::vector<PolicyFault>& faults) {
  return std::any_of(audit.explanations.begin(), audit.explanations.end(), [&](const Explanation& explanation) {
    return explanation.is_named && explanation.corrections.size() == faults.size() &&
           std::all_of(faults.begin(), faults.end(), [&](const PolicyFault& fault) {
             return std::any_of(fault.named_by.begin(), fault.named_by.end(), [&](const std::string& words) {
               return std::any_of(explanation.corrections.begin(), explanation.corrections.end(),
                                  [&](const std::string& found) { return found.rfind(words, 0) == 0; });
             });
           });
  });
}

std::string nameOf(const std::vector<PolicyFault>& faults) {
  std::vector<std::string> parts;
  for (const PolicyFault& fault : faults) {
    parts.push_back(fault.name);
  }
  return pusht::joined(parts, " + ");
}

TEST(PolicyAudit, Survey) {
  for (const Shipped& shipped : shippedPolicies()) {
    if (std::getenv("KIND") && shipped.kind != std::getenv("KIND")) continue;
    const Loaded loaded(shipped);
    std::cout << "== " << loaded.kind << std::endl;
    const PolicyAudit sound = auditPolicy(*loaded.policy, loaded.signature, heldDemonstrations());
    std::cout << textOf(sound, loaded.kind, "held") << std::endl;
    for (const PolicyFault& fault : plantedPolicyFaults(otherDemonstrations())) {
      if (!fault.fits(loaded.signature)) {
        continue;
      }
      if (std::getenv("FAULT") && fault.name != std::getenv("FAULT")) continue;
      const auto begin = std::chrono::steady_clock::now();
      const PolicyAudit audit = loaded.audit({fault});
      const bool named = names(audit, {fault});
      std::cout << std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() << " ";
      std::cout << (named ? "ok     " : "MISSED ") << fault.name << "  " << audit.error.value << " const "
                << audit.constant.value << std::endl;
      if (!named) {
        std::cout << textOf(audit, loaded.kind, "held");
      }
    }
  }
}

}  // namespace
}  // namespace sim2sim::testing
