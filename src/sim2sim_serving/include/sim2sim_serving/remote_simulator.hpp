// SPDX-License-Identifier: BSD-3-Clause
/// Simulator in another node, in any language.
#pragma once

#include <pusht_msgs/Configure.h>
#include <pusht_msgs/Describe.h>
#include <pusht_msgs/Reset.h>
#include <pusht_msgs/Step.h>

#include <cstdint>
#include <optional>
#include <string>

#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/simulator.hpp"
#include "sim2sim_serving/node_parameters.hpp"
#include "sim2sim_serving/peer.hpp"

namespace pusht {

/// Source of stamps that grow by a control step, over resets and runs.
class StampSource {
 public:
  const ros::Time& now() const { return now_; }
  void advance();
  /// Raises now() to at least `stamp`; the next advance() lies above it.
  void raiseTo(const ros::Time& stamp);

 private:
  ros::Time now_;
};

/// Maximum deviation of a node's world after a reset from the requested state [m, rad, m/s, rad/s]: as the node
/// describes it, else kStartTolerance. Throws BadDependency for a value that is not allowed.
double startToleranceOf(const pusht_msgs::DescribeResponse& description);

/// World behind the services of a peer. It holds the world, which refuses other callers meanwhile. Functions also throw
/// PeerFault, RuntimeFault if another caller has reset or configured the world, and BadDependency for a state in pixels
/// that is not the state. Requests have the stamp of
/// `stamps`, which the caller advances before each reset and step, once for all worlds that share them, unless they are
/// silent.
class RemoteSimulator : public Simulator {
 public:
  /// Takes the world over from any holder. The peer must be connected; peer and stamps must outlive the simulator. A
  /// `kind` makes the world one of that kind, with its defaults; an empty one keeps the kind. Then `changes` are set.
  /// The world becomes one of `task`. Kind and parameters must stay so. Throws as startToleranceOf(); the error with
  /// which the node refuses; BadDependency if the node describes another kind afterwards.
  RemoteSimulator(const Peer& peer, StampSource& stamps, const std::string& kind = "", Parameters changes = {},
                  const Task& task = fullCircle());

  /// Releases the world, if it still answers.
  ~RemoteSimulator() override;

  /// Sets index and greatest number of control steps of the episode that the next reset begins: the node refuses steps
  /// beyond it (0: the task's). Ends silence().
  void announce(std::uint64_t episode, int horizon);

  /// Makes the next resets and their steps silent until the next announcement: the node publishes nothing.
  void silence() { silent_ = true; }

  /// State in gym-pusht's frame, if the node's world is computed there.
  const gym_pusht::State* stateInPixels() const override { return state_in_pixels_ ? &*state_in_pixels_ : nullptr; }

  /// Description of the node. Throws PeerFault if the node was replaced, RuntimeFault if its kind or parameters have
  /// changed, BadDependency if it has another version than at first.
  pusht_msgs::DescribeResponse describe();

 private:
  /// Simulator that has not taken the world over yet.
  RemoteSimulator(const Peer& peer, const StampSource& stamps, const pusht_msgs::DescribeResponse& description,
                  const Task& task);

  void doReset(const WorldState& state) override;
  void doSpawn(const WorldState& start, std::uint64_t seed) override;
  void doStep(const Action& action) override;
  WorldState doState() const override { return state_; }

  template <class Response>
  void keepState(const Response& response);
  void configure(const std::string& kind, const Parameters& changes);
  void requestReset(const WorldState& start, pusht_msgs::ResetRequest request);
  pusht_msgs::ResetResponse take(pusht_msgs::ResetRequest request);
  void requireParameters(const std::string& hash) const;

  const Peer& peer_;
  const StampSource& stamps_;
  ServiceCaller<pusht_msgs::Describe> describe_;
  ServiceCaller<pusht_msgs::Configure> configure_;
  ServiceCaller<pusht_msgs::Reset> reset_;
  ServiceCaller<pusht_msgs::Step> step_;
  std::string kind_;             // kind that the world must have; kinds with equal parameters have equal hashes
  std::string version_;          // version that the kind had when the world was taken over
  bool says_task_;               // whether the kind's description has a task
  std::string parameters_hash_;  // hash of the parameters that the world must have
  std::string token_;            // token of the hold; a new one for each reset; empty: not held
  std::uint64_t episode_ = 0;
  int horizon_ = 0;
  bool silent_ = false;
  int next_step_ = 0;
  WorldState state_;
  std::optional<gym_pusht::State> state_in_pixels_;
};

}  // namespace pusht
