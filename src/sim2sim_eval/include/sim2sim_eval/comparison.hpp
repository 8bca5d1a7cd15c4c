// SPDX-License-Identifier: BSD-3-Clause
/// The comparison in process: what `rosrun sim2sim_eval compare` does.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_eval/batch_options.hpp"
#include "sim2sim_eval/protocol.hpp"
#include "sim2sim_eval/report.hpp"

namespace sim2sim {

struct CompareOptions {
  Protocol protocol;
  std::string policy = pusht::kShippedPolicy;  ///< as in pusht::PolicyChoice
  bool require_policy = false;
  pusht::TwoMassParameters knobs;
  bool smoke = false;  ///< an untrained policy, whatever `policy` says, and smokeRun(protocol)
  std::string scene;   ///< MJCF file; empty: the installed one
  std::string out;     ///< results folder; empty: the next free results/compare-N
  bool overwrite = false;
  bool record = false;  ///< write compare.bag
  BatchOptions batch;

  /// Declares the options on a command line.
  void declare(CLI::App& app);

  /// The run they ask for; its policy is the string given.
  RunConfiguration configuration() const;
};

/// Runs the protocol, writes the results folder and prints the table. Throws an Error of its kind on failure;
/// finished episodes are kept then.
void compare(const CompareOptions& options);

}  // namespace sim2sim
