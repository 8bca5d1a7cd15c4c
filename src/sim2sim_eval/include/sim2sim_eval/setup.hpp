// SPDX-License-Identifier: BSD-3-Clause
/// What runs in process: the reference with its scene, the engine, the policy.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_mujoco/mujoco_scene.hpp"
#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_eval/protocol.hpp"
#include "sim2sim_eval/report.hpp"

namespace sim2sim {

/// The names that MuJoCo and the two-mass engine give themselves, and the values of its knobs, in `configuration`.
void describeSimulators(RunConfiguration& configuration, const pusht::TwoMassParameters& knobs);

/// Simulators and policy, loaded once for all runs of a process.
class Setup {
 public:
  /// `scene`: MJCF file; empty: the installed one. Warns on stderr if another policy runs than was asked for. Throws as
  /// MujocoScene and choosePolicy do.
  Setup(const pusht::PolicyChoice& policy, const std::string& scene);

  /// The string given, or "fresh-untrained".
  const std::string& policyName() const { return policy_.name; }

  Players players(const pusht::TwoMassParameters& knobs) const;

  /// provenance.json of a run; its "code" says which machine code decides the results.
  nlohmann::ordered_json provenance(const RunConfiguration& configuration) const;

  /// Fingerprints of policy and scene, wherever they lie.
  nlohmann::json identity() const;

  /// All that a rollout of the reference depends on, besides its spawn seed: policy, scene, horizon, and the machine
  /// code that computes it.
  nlohmann::json referenceKey(int horizon) const;

 private:
  std::shared_ptr<const pusht::MujocoScene> scene_;
  pusht::ChosenPolicy policy_;
  nlohmann::json code_;  // which decides the bits of the results
};

}  // namespace sim2sim
