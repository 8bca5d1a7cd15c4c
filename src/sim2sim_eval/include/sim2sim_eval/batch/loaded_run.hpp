// SPDX-License-Identifier: BSD-3-Clause
/// What runs in process: the reference, the engine, the policy.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_eval/simulators.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/runner.hpp"

namespace sim2sim {

/// Reference and policy, loaded once for all runs of a process.
class LoadedRun {
 public:
  /// `engines` are the kinds that the reference is compared with. Warns on stderr if another policy runs than was asked
  /// for. Throws as SimulatorKind::load and choosePolicy do.
  LoadedRun(const pusht::PolicyChoice& policy, const SimulatorChoice& reference,
            const std::vector<SimulatorChoice>& engines);

  /// The string given, or "fresh-untrained".
  const std::string& policyName() const { return policy_.name; }

  const LoadedSimulator& reference() const { return reference_; }

  WorkerFactory workerFactory(const LoadedSimulator& engine) const;

  /// provenance.json of a run; its "code" says which machine code decides the results.
  nlohmann::ordered_json provenance(const RunConfiguration& configuration, const LoadedSimulator& engine) const;

  /// Policy and reference by their content, wherever their files lie.
  nlohmann::json identity() const;

  /// All that a rollout of the reference depends on, besides its initial state: policy, reference, the options that
  /// decide it (Decides::kReference), and the machine code that computes it.
  nlohmann::json referenceKey(const RunOptions& options) const;

 private:
  LoadedSimulator reference_;
  pusht::ChosenPolicy policy_;
  nlohmann::json reference_code_;  // which decides the bits of the reference's rollouts
  nlohmann::json code_;            // which decides the bits of the results
};

}  // namespace sim2sim
