// SPDX-License-Identifier: BSD-3-Clause
/// A simulator in another node, in any language.
#pragma once

#include <pusht_msgs/Configure.h>
#include <pusht_msgs/Describe.h>
#include <pusht_msgs/Reset.h>
#include <pusht_msgs/Step.h>

#include <cstdint>
#include <string>

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

/// [m, rad, m/s, rad/s] How near to where it was told to the world of a node starts: what the node says of itself, or
/// what the task asks for if it does not. Throws BadDependency if it says what no simulator may.
double startToleranceOf(const pusht_msgs::DescribeResponse& description);

/// A world that is reset and stepped by services, and held meanwhile: others are refused. Beyond what Simulator says,
/// it throws PeerFault, and RuntimeFault if another caller has reset the world or set its parameters. A step request is
/// stamped with the time of `stamps`, which whoever drives the worlds advances before each reset and step, unless these
/// are silent.
class ServedSimulator : public Simulator {
 public:
  /// Takes the world over, whoever holds it. The peer must be connected; all must outlive the simulator. With a `kind`
  /// the world becomes one of that, with its defaults; empty: it stays what it is. Then `changes` are set. From now on
  /// it must be of the kind and have the parameters that come of this. Throws as startToleranceOf, too; the error with
  /// which the node refuses; BadDependency if it describes another kind than the one that it is asked for.
  ServedSimulator(const Peer& peer, StampSource& stamps, const std::string& kind = "", const Parameters& changes = {});

  /// Leaves the world to others, if it still answers.
  ~ServedSimulator() override;

  /// The episode that the next reset begins.
  void announce(std::uint64_t episode, int horizon);

  /// Until the next announcement, what resets begin is not published, and stamps rest.
  void silence() { silent_ = true; }

  /// What the node says of itself. Throws PeerFault if it is another one by now, RuntimeFault if its kind or parameters
  /// are not those that it must have.
  pusht_msgs::DescribeResponse describe();

 private:
  /// Not yet taken over.
  ServedSimulator(const Peer& peer, const StampSource& stamps, double start_tolerance);

  void doReset(const WorldState& state) override;
  void doStep(const Action& action) override;
  WorldState doState() const override { return state_; }

  void configure(const std::string& kind, const Parameters& changes);
  pusht_msgs::ResetResponse take(pusht_msgs::ResetRequest request);
  void requireParameters(const std::string& hash) const;

  const Peer& peer_;
  const StampSource& stamps_;
  ServiceCaller<pusht_msgs::Describe> describe_;
  ServiceCaller<pusht_msgs::Configure> configure_;
  ServiceCaller<pusht_msgs::Reset> reset_;
  ServiceCaller<pusht_msgs::Step> step_;
  std::string kind_;             // that it must be of: kinds with equal parameters have equal hashes
  std::string parameters_hash_;  // of those that it must have
  std::string token_;            // of the hold; another one for each reset
  std::uint64_t episode_ = 0;
  int horizon_ = 0;
  bool silent_ = false;
  int next_step_ = 0;
  WorldState state_;
};

}  // namespace pusht
