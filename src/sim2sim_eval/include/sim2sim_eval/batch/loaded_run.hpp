// SPDX-License-Identifier: BSD-3-Clause
/// Loaded parts of runs in one process: the reference and the policy, with their code and provenance.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/runner.hpp"

namespace sim2sim {

/// Reference and policy, loaded once for all runs of a process. The engine is added by run.
class LoadedRun {
 public:
  /// `engines` are all engines that the reference is compared with; their libraries are part of the code fingerprint.
  /// `options` has the names of the model variants (nameVariants()). Warns on stderr if another policy runs than was
  /// asked for. Throws as SimulatorKind::load and choosePolicy.
  LoadedRun(const pusht::PolicyChoice& policy, const SimulatorChoice& reference,
            const std::vector<SimulatorChoice>& engines, const RunOptions& options);

  /// Likewise with the policy that `choose_policy` returns, and what that throws.
  LoadedRun(const std::function<pusht::ChosenPolicy()>& choose_policy, const SimulatorChoice& reference,
            const std::vector<SimulatorChoice>& engines, const RunOptions& options);

  /// Name of the policy that runs: as given, or "fresh-untrained".
  const std::string& policyName() const { return policy_.name; }

  const LoadedSimulator& reference() const { return reference_; }

  WorkerFactory workerFactory(const LoadedSimulator& engine) const;

  /// Content of provenance.json; its "code" is the fingerprint of the machine code that decides the results.
  nlohmann::ordered_json provenance(const RunConfiguration& configuration, const LoadedSimulator& engine) const;

  /// Policy and reference by content (hashes, parameters), independent of the paths of their files.
  nlohmann::json identity() const;

  /// Cache key of the reference's rollouts, without the initial state: policy, reference, the options that decide it
  /// (Decides::kReference), and the fingerprint of the machine code that computes it.
  nlohmann::json referenceKey(const RunOptions& options) const;

 private:
  LoadedSimulator reference_;
  std::vector<pusht::SimulatorModel> variants_;
  pusht::ChosenPolicy policy_;
  nlohmann::json reference_code_;  // fingerprint of the code that decides the bits of the reference's rollouts
  nlohmann::json code_;            // fingerprint of the code that decides the bits of the results
};

}  // namespace sim2sim
