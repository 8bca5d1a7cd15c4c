// SPDX-License-Identifier: BSD-3-Clause
/// Comparison in one process. Work of `rosrun sim2sim_eval compare` and of compare() in Python.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_eval/batch/batch_options.hpp"
#include "sim2sim_eval/batch/command_line.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Command line of `compare`.
struct CompareOptions {
  Protocol protocol;
  bool episodes_given = false;                 ///< else defaultEpisodes()
  std::string policy = pusht::kShippedPolicy;  ///< path or name, as in pusht::PolicyChoice
  bool require_policy = false;
  bool allow_untrained = false;
  std::string reference = kCourseReference;         ///< name of a kind
  std::vector<std::string> reference_parameters{};  ///< "NAME=VALUE", as for chooseSimulator()
  std::string engine = kCourseEngine;               ///< name of a kind
  std::vector<std::string> engine_parameters{};
  bool smoke = false;        ///< run smokeRun(protocol) with an untrained policy, whatever `policy` says
  std::string starts;        ///< file for readInitialStates(); empty: spawn seeds
  std::string write_starts;  ///< file to write the initial states into, as CSV; empty: none
  std::string out;           ///< results folder; empty: the next free results/compare-N
  bool overwrite = false;
  bool record = false;  ///< write compare.bag
  bool traces = false;  ///< write traces.npy
  BatchOptions batch;

  /// Whether the run can continue after an interruption: not with a bag or traces, which cannot be extended.
  bool goesOn() const { return !record && !traces; }

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// What a comparison takes from the program around it. The defaults are those of the command.
struct ComparisonHost : CommandHost {
  std::function<pusht::ChosenPolicy()> choose_policy{};  ///< a policy of the program's own; empty: that of the options
  bool can_return = true;  ///< whether a later run could have the same policy and simulators, and so be continued
  bool files = true;       ///< false: no folder of results
};

/// Results of a comparison: what its files say.
struct ComparisonResults {
  RunConfiguration configuration;
  std::vector<EpisodeResult> episodes;  ///< by index
  nlohmann::json metrics;
  nlohmann::ordered_json provenance;
  std::filesystem::path folder;  ///< of the results; empty: none
};

/// Runs the protocol, writes the results folder, and prints the table. An unfinished run in the folder is
/// continued; its results have the bytes of a run in one piece. Throws InvalidInput for bad options, BadDependency
/// for a policy or model that does not load, SimulationFault or RuntimeFault during the run; finished episodes are kept
/// then.
ComparisonResults compare(const CompareOptions& options, const ComparisonHost& host = {});

}  // namespace sim2sim
