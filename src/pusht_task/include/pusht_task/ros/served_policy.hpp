// SPDX-License-Identifier: BSD-3-Clause
/// A policy in another node, in any language.
#pragma once

#include <pusht_msgs/Act.h>

#include <memory>

#include "pusht_task/policy.hpp"
#include "pusht_task/rollout_ids.hpp"
#include "pusht_task/ros/peer.hpp"

namespace pusht {

/// A policy that is asked by a service. Beyond what Policy says, act() throws PeerFault, or BadDependency for an answer
/// of the wrong size.
class ServedPolicy : public Policy {
 public:
  /// The peer must be connected before the first act(), and outlive the policy.
  explicit ServedPolicy(const Peer& peer);

  /// What the policy itself remembers is on the other end; here is what the rollout is called there.
  std::unique_ptr<Memory> begin() const override;

  void act(Span<const Query> queries, Span<Action> actions) override;

 private:
  ServiceCaller<pusht_msgs::Act> act_;
  mutable RolloutIds ids_;
};

}  // namespace pusht
