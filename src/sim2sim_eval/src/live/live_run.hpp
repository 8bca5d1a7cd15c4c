// SPDX-License-Identifier: BSD-3-Clause
/// Protocol over nodes: one episode at a time, worlds in lockstep, at a rate.
#pragma once

#include <ros/time.h>

#include <chrono>
#include <functional>

#include "live/live_nodes.hpp"
#include "live/pacer.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Observer of a live run. All functions are called in the thread of runLive().
class LiveObserver {
 public:
  LiveObserver() = default;
  LiveObserver(const LiveObserver&) = delete;
  LiveObserver& operator=(const LiveObserver&) = delete;
  virtual ~LiveObserver() = default;

  /// Called at the initial state of an episode and after every control step. An episode that was void begins again with
  /// step 0.
  virtual void onStep(const Episode& episode, const ros::Time& stamp) = 0;
  /// Called for a finished episode. Returns whether the run needs further episodes.
  virtual bool onFinish(const Episode& episode, const ros::Time& stamp) = 0;
  /// Called when `episode` is left before its end, because of an error or a stop.
  virtual void onBreak(const Episode& episode) = 0;
  /// Called when a node is lost in `episode`. The episode is void, and the run waits for the node to come back.
  virtual void onFault(int episode, const pusht::PeerFault& fault) = 0;
  /// Called when the lost nodes are back.
  virtual void onRecovery() = 0;
  /// Called when the loss of a node in `episode` ends the run. After it the run waits for the options' `grace`, because
  /// a stop from outside (Ctrl-C of a launch) may end the nodes first.
  virtual void onLoss(int episode, const pusht::PeerFault& fault) = 0;
};

/// Parameters of a live run besides its protocol.
struct LiveOptions {
  LiveNodes::Simulators simulators;
  pusht::Peer::Wait wait;  ///< for nodes; without `respawn` a lost node ends the run; `stop` ends it in any case
  std::chrono::milliseconds grace;  ///< after a lost node, time in which `stop` turns the fault into an interruption
};

/// Connects to the nodes for the first time. Throws as LiveNodes::connect(), but RuntimeFault if `stop` holds, or holds
/// within the grace after a node was lost.
void connectFirst(LiveNodes& nodes, const LiveOptions& options);

/// Runs the episodes of `protocol` over connected nodes; `variants` are the worlds of its model variants, in process.
/// The fifth node lost in one episode ends the run. Throws PeerFault for a node that is lost for good, RuntimeFault
/// when the options' `stop` holds; as Flight otherwise.
void runLive(const Protocol& protocol, LiveNodes& nodes, const VariantWorlds& variants, Pacer& pacer,
             LiveObserver& observer, const LiveOptions& options);

}  // namespace sim2sim
