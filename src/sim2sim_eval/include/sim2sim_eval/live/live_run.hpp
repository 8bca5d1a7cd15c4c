// SPDX-License-Identifier: BSD-3-Clause
/// The protocol over nodes: one episode at a time, in lockstep, at a rate.
#pragma once

#include <ros/time.h>

#include <chrono>
#include <functional>

#include "sim2sim_eval/live/live_nodes.hpp"
#include "sim2sim_eval/live/pacer.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Told of a live run as it goes on.
class LiveObserver {
 public:
  LiveObserver() = default;
  LiveObserver(const LiveObserver&) = delete;
  LiveObserver& operator=(const LiveObserver&) = delete;
  virtual ~LiveObserver() = default;

  /// The start of an episode, and every control step. An episode that a fault has made void begins again from 0.
  virtual void onStep(const Episode& episode, const ros::Time& stamp) = 0;
  /// Returns whether the run needs further episodes.
  virtual bool onFinish(const Episode& episode, const ros::Time& stamp) = 0;
  /// `episode` is left before its end, by an error or because the run is to stop.
  virtual void onBreak(const Episode& episode) = 0;
  /// A node was lost in `episode`, which is void; the run waits for the node to come back.
  virtual void onFault(int episode, const pusht::PeerFault& fault) = 0;
  /// The nodes that were lost are back.
  virtual void onRecovery() = 0;
  /// A node was lost in `episode`, which ends the run. The run waits for the options' `grace` whether it was to stop
  /// anyway, for what ends the run may end its nodes first.
  virtual void onLoss(int episode, const pusht::PeerFault& fault) = 0;
};

struct LiveOptions {
  LiveNodes::Simulators simulators;
  pusht::Peer::Wait wait;  ///< for nodes; without `respawn` a fault ends the run, and `stop` ends it in any case
  std::chrono::milliseconds grace;  ///< what ends the run may end its nodes first: a lost node waits so long for `stop`
};

/// Connects `cast` for the first time; throws as LiveNodes::connect() does, or RuntimeFault if a node is lost because
/// the run is to stop.
void connectFirst(LiveNodes& nodes, const LiveOptions& options);

/// Runs the episodes of `protocol` over a cast that is connected. Throws PeerFault for a node that is lost for good,
/// RuntimeFault when the options' `stop` holds; as Episode does otherwise.
void runLive(const Protocol& protocol, LiveNodes& nodes, Pacer& pacer, LiveObserver& observer,
             const LiveOptions& options);

}  // namespace sim2sim
