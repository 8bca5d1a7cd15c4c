// SPDX-License-Identifier: BSD-3-Clause
/// The comparison in process: what `rosrun sim2sim_eval compare` does.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_eval/batch/batch_options.hpp"
#include "sim2sim_eval/simulators.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

struct CompareOptions {
  Protocol protocol;
  bool episodes_given = false;                 ///< else defaultEpisodes()
  std::string policy = pusht::kShippedPolicy;  ///< as in pusht::PolicyChoice
  bool require_policy = false;
  bool allow_untrained = false;
  std::string reference = kCourseReference;         ///< kind
  std::vector<std::string> reference_parameters{};  ///< as in chooseSimulator()
  std::string engine = kCourseEngine;               ///< kind
  std::vector<std::string> engine_parameters{};
  bool smoke = false;        ///< an untrained policy, whatever `policy` says, and smokeRun(protocol)
  std::string starts;        ///< file for readInitialStates(); empty: spawn seeds
  std::string write_starts;  ///< file to write them into; empty: none
  std::string out;           ///< results folder; empty: the next free results/compare-N
  bool overwrite = false;
  bool record = false;  ///< write compare.bag
  bool traces = false;  ///< write traces.npy
  BatchOptions batch;

  /// Whether the run continues after an interruption. A bag, or traces, of a part of a run cannot be added to.
  bool goesOn() const { return !record && !traces; }

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Runs the protocol, writes the results folder and prints the table; a run that the folder holds unfinished goes on,
/// with the bytes of a run in one piece. Throws an Error of its kind on failure; finished episodes are kept then.
void compare(const CompareOptions& options);

}  // namespace sim2sim
