// SPDX-License-Identifier: BSD-3-Clause
/// A simulator in another node, in any language.
#pragma once

#include <pusht_msgs/Configure.h>
#include <pusht_msgs/Reset.h>
#include <pusht_msgs/Step.h>

#include <cstdint>

#include "pusht_task/ros/parameters.hpp"
#include "pusht_task/ros/peer.hpp"
#include "pusht_task/simulator.hpp"

namespace pusht {

/// Stamps that grow by a control step, whatever begins anew.
class StampSource {
 public:
  const ros::Time& now() const { return now_; }
  void advance();
  /// From now on the stamps are above `stamp` too.
  void startAbove(const ros::Time& stamp);

 private:
  ros::Time now_;
};

/// A world that is reset and stepped by services; beyond what Simulator says, it throws PeerFault. A step request is
/// stamped with the time of `stamps`, which whoever drives the worlds advances before each reset and step.
class ServedSimulator : public Simulator {
 public:
  /// The peer must be connected before the first reset. All must outlive the simulator.
  ServedSimulator(const Peer& peer, const StampSource& stamps);

  /// The episode that the next reset begins.
  void announce(std::uint64_t episode, int horizon);

  /// Sets parameters, and ends the episode under way. Returns all of them as they are now.
  Parameters configure(const Parameters& changes);

 private:
  void doReset(const WorldState& state) override;
  void doStep(const Action& action) override;
  WorldState doState() const override { return state_; }

  const StampSource& stamps_;
  ServiceCaller<pusht_msgs::Configure> configure_;
  ServiceCaller<pusht_msgs::Reset> reset_;
  ServiceCaller<pusht_msgs::Step> step_;
  std::uint64_t episode_ = 0;
  int horizon_ = 0;
  int next_step_ = 0;
  WorldState state_;
};

}  // namespace pusht
