// SPDX-License-Identifier: BSD-3-Clause
/// The private parameters of the evaluator.
#pragma once

#include <string>

#include "pusht_task/ros/parameters.hpp"
#include "sim2sim_eval/live/request.hpp"

namespace sim2sim {

/// Private parameters of the evaluator; forEachOption() has those of RunOptions.
struct EvaluatorParameters {
  LiveRequest request;      ///< what a goal leaves open
  bool start = false;       ///< run `request` at once
  bool exit = false;        ///< and end then, unless rviz shows it
  bool respawn = false;     ///< nodes that die come back: their episode is run again
  double deadline = 5.0;    ///< [s] for the answer to a call
  double patience = 30.0;   ///< [s] for a node to appear, or to come back
  double grace = 2.0;       ///< [s] for the stop of a run that explains why a node is lost
  std::string status_file;  ///< a copy of status.json, under way first; empty: none
  bool report = false;      ///< write a report of each run that finishes
  std::string headless;     ///< why rviz does not show what runs; empty: it does, and the node stays when it has run

  /// Throws InvalidInput with key, value and rule.
  static EvaluatorParameters load(pusht::ParameterReader& parameters);

  /// The places of a run's outcome alone, where load() has thrown; empty: none is named.
  static std::string outOf(pusht::ParameterReader& parameters);
  static std::string statusFileOf(pusht::ParameterReader& parameters);
};

}  // namespace sim2sim
