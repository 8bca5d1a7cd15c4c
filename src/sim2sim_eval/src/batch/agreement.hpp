// SPDX-License-Identifier: BSD-3-Clause
/// Agreement of all pairs of several simulators. Work of `rosrun sim2sim_eval agreement`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_eval/batch/batch_options.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Command line of `agreement`.
struct AgreementOptions {
  AgreementOptions();

  std::vector<std::string> simulators;  ///< two or more, as for simulatorFromText()
  std::string reference;                ///< simulator whose episodes all replay; empty: the first one
  bool both_ways = false;               ///< all replay the episodes of each simulator instead
  bool variants = true;                 ///< measure each simulator's own model variants, too
  Protocol protocol;
  bool episodes_given = false;  ///< else defaultEpisodes()
  std::string policy = pusht::kShippedPolicy;
  std::string starts;         ///< file for readInitialStates(); empty: spawn seeds
  std::filesystem::path out;  ///< new JSON file; empty: none
  BatchOptions batch;

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Runs the policy in the reference, or in each simulator, replays its actions in all, re-anchored and in open loop,
/// prints the distances of all pairs, and writes them. Throws InvalidInput for bad options or a file that is there
/// already; BadDependency for a policy or model that does not load; SimulationFault or RuntimeFault during the run.
void agreement(const AgreementOptions& options);

}  // namespace sim2sim
