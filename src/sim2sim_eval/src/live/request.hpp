// SPDX-License-Identifier: BSD-3-Clause
/// Request of a live run: parameters of the evaluator, with the fields of a goal on top.
#pragma once

#include <pusht_msgs/CompareGoal.h>

#include <optional>
#include <string>
#include <vector>

#include "live/live_nodes.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace sim2sim {

/// Request of one comparison.
struct LiveRequest {
  LiveNodes::Services services;
  std::string policy{};  ///< name that the policy must have; empty: any
  Protocol protocol;
  bool smoke = false;  ///< short run; the policy's node should serve the untrained policy
  double rate = 0.0;   ///< [control steps/s]; 0: as fast as possible
  LiveNodes::Simulators simulators;
  bool record = true;      ///< write compare.bag
  std::string starts;      ///< file for readInitialStates(); empty: spawn seeds
  std::string out;         ///< folder for the results; empty: the next free results/compare-N
  bool overwrite = false;  ///< replace results that are in the folder
};

/// Parameters from "NAME=VALUE NAME=VALUE"; a value may hold spaces. Throws InvalidInput, with `what` in front, for
/// another text, a name that is set twice, or more than 10 000 bytes.
pusht::Parameters parametersFrom(const std::string& what, const std::string& text);

/// First of `out`, out-2, out-3, ... into which a run without `overwrite` may write its results. An empty `out` stays
/// empty: the run then takes the next free results/compare-N.
std::string freeFolder(const std::string& out);

/// Request with the fields of `goal` on top; an empty field leaves the request as it is. Throws InvalidInput with
/// field, value and rule.
LiveRequest merged(LiveRequest request, const pusht_msgs::CompareGoal& goal);

/// Calls function(name, access) for each field of a request that is neither an option of the run nor about nodes.
/// access(o) returns the field of a request or of a goal.
template <class Function>
void forEachLiveField(const Function& function) {
  function(
      "rate", [](auto& o) -> auto& { return o.rate; });
  function(
      "record", [](auto& o) -> auto& { return o.record; });
  function(
      "starts", [](auto& o) -> auto& { return o.starts; });
  function(
      "out", [](auto& o) -> auto& { return o.out; });
  function(
      "overwrite", [](auto& o) -> auto& { return o.overwrite; });
}

/// Goal with the options of a run, and no other field.
pusht_msgs::CompareGoal goalOf(const RunOptions& options);

/// Goal with all fields of `request`.
pusht_msgs::CompareGoal goalOf(const LiveRequest& request);

}  // namespace sim2sim
