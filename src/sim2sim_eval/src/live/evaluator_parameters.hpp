// SPDX-License-Identifier: BSD-3-Clause
/// Private parameters of the evaluator's node.
#pragma once

#include <string>

#include "live/request.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace sim2sim {

/// Private parameters of the evaluator; forEachOption() has those of RunOptions.
struct EvaluatorParameters {
  LiveRequest request;      ///< values of fields that a goal leaves open
  bool start = false;       ///< run `request` at once
  bool exit = false;        ///< end the node after that run, unless rviz shows it
  bool respawn = false;     ///< wait for lost nodes to come back, and run their episode again
  double deadline = 5.0;    ///< [s] within which a call must be answered
  double patience = 30.0;   ///< [s] to wait for a node to appear, or to come back
  double grace = 2.0;       ///< [s] after the loss of a node in which a stop of the run explains the loss
  std::string status_file;  ///< path of a copy of status.json, written from the start; empty: none
  bool report = false;      ///< write a report of each run that finishes
  std::string headless;     ///< reason why rviz does not show the run; empty: rviz does, and the node stays afterwards

  /// Reads all parameters. Throws InvalidInput with key, value and rule.
  static EvaluatorParameters load(pusht::ParameterReader& parameters);

  /// Results folder and status file alone, to report an error of load(); empty: none is named.
  static std::string outOf(pusht::ParameterReader& parameters);
  static std::string statusFileOf(pusht::ParameterReader& parameters);
};

}  // namespace sim2sim
