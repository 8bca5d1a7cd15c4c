// SPDX-License-Identifier: BSD-3-Clause
/// Audits of policies as the command `audit --policy` and Python carry them out.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_audit/policy_audit.hpp"

namespace sim2sim {

/// Loss of a policy's training, as its provenance has it.
struct TrainingLoss {
  std::string name;         ///< "mean squared error in normalised action space"; empty: unknown
  double training = 0.0;    ///< in the last epoch
  double validation = 0.0;  ///< on demonstrations that it was not trained on
};

/// Audit of a policy, and whom it is about.
struct PolicyAuditRun {
  std::string policy;          ///< name or file, as given
  std::string sha256{};        ///< of its file; empty: none
  std::string demonstrations;  ///< their file, or what they are
  TrainingLoss loss{};
  PolicyAudit audit{};

  /// Text for people, the verdict first.
  std::string text() const;
  /// Text of the JSON file.
  std::string json() const;
};

/// Signature of a policy, by its provenance. One that has none, as the expert, may remember anything.
PolicySignature signatureOf(const pusht::ChosenPolicy& policy);

/// Asks a policy with demonstrations. Once the process is interrupted it is not asked any more. Throws as
/// auditPolicy(), with the policy's name; RuntimeFault if the process is interrupted.
PolicyAudit auditNamedPolicy(pusht::Policy& policy, const std::string& name, const PolicySignature& signature,
                             const std::vector<Demonstration>& demonstrations);

/// Audit of a policy of the suite, or in a file; who calls it names the demonstrations. Throws as choosePolicy() and
/// auditNamedPolicy().
PolicyAuditRun auditPolicyFile(const std::string& policy, const std::vector<Demonstration>& demonstrations);

/// Demonstrations in a file: a bag of `demonstrate`, or a CSV if its name ends in .csv, whose first line names the
/// columns, in any order; those of other names are not read. `episode`, where there is one, is the same for the rows of
/// an episode, which follow each other. Observations are o0 to o9 or pusher_x, ... (docs/audit.md), actions a0, a1 or
/// action_x, action_y. Throws InvalidInput, naming the file and where in it something is wrong, the value and the rule;
/// RuntimeFault if reading fails.
std::vector<Demonstration> readDemonstrations(const std::filesystem::path& path);

}  // namespace sim2sim
