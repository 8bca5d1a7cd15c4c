// SPDX-License-Identifier: BSD-3-Clause
/// What a live run is asked to do: by parameters, and by goals on top of them.
#pragma once

#include <pusht_msgs/CompareGoal.h>

#include <optional>
#include <string>
#include <vector>

#include "pusht_task/ros/parameters.hpp"
#include "sim2sim_eval/live/live_nodes.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// One comparison that is asked for.
struct LiveRequest {
  LiveNodes::Services services;
  std::string policy{};  ///< the name that the policy must have; empty: any
  Protocol protocol;
  bool smoke = false;  ///< short; the policy node should be given the untrained policy
  double rate = 0.0;   ///< [control steps/s]; 0: as fast as possible
  LiveNodes::Simulators simulators;
  bool record = true;      ///< write compare.bag
  std::string starts;      ///< file for readInitialStates(); empty: spawn seeds
  std::string out;         ///< folder for the results; empty: the next free results/compare-N
  bool overwrite = false;  ///< replace results that are in the folder
};

/// "NAME=VALUE NAME=VALUE"; a value may hold spaces. Throws InvalidInput with `what` if the text is none, sets a name
/// twice, or has more than 10 000 bytes.
pusht::Parameters parametersFrom(const std::string& what, const std::string& text);

/// `out` if a run without overwrite may write its results there; else the first of out-2, out-3 and so on that it may.
/// Empty stays empty: then the run finds its place.
std::string freeFolder(const std::string& out);

/// `goal` on top of `request`. Throws InvalidInput with the field of the goal that cannot be.
LiveRequest merged(LiveRequest request, const pusht_msgs::CompareGoal& goal);

/// Calls function(name, access) for each field of a request that is neither an option of the run nor about nodes;
/// access(o) is the field in a request, or in a goal.
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

/// The options of a run as a goal that names nothing else.
pusht_msgs::CompareGoal goalOf(const RunOptions& options);

/// All of `request` as a goal.
pusht_msgs::CompareGoal goalOf(const LiveRequest& request);

}  // namespace sim2sim
