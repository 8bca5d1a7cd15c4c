// SPDX-License-Identifier: BSD-3-Clause
/// Policy in another node, in any language.
#pragma once

#include <pusht_msgs/Act.h>

#include <memory>

#include "pusht_task/policy.hpp"
#include "pusht_task/rollout_ids.hpp"
#include "sim2sim_serving/peer.hpp"

namespace pusht {

/// Policy behind the service `act` of a peer. act() also throws PeerFault, and BadDependency for an answer of the wrong
/// size.
class RemotePolicy : public Policy {
 public:
  /// The peer must be connected before the first act(), and outlive the policy.
  explicit RemotePolicy(const Peer& peer);

  /// Id of a new rollout. The policy's own memory is at the peer.
  std::unique_ptr<Memory> begin(const Beginning& beginning) const override;

  void act(Span<const Query> queries, Span<Action> actions) override;

 private:
  ServiceCaller<pusht_msgs::Act> act_;
  mutable RolloutIds ids_;
};

}  // namespace pusht
