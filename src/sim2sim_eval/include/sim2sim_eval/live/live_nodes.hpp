// SPDX-License-Identifier: BSD-3-Clause
/// The nodes that play in a live run.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "pusht_task/ros/peer.hpp"
#include "pusht_task/ros/served_policy.hpp"
#include "pusht_task/ros/served_simulator.hpp"
#include "sim2sim_eval/live/world_memory.hpp"
#include "sim2sim_protocol/flight.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Three served worlds and a served policy. What they are is fixed when they are first connected to: a node
/// that comes back after a fault must be the same again.
class LiveNodes {
 public:
  struct Services {
    std::array<std::string, kModeCount> worlds;  ///< service namespaces, by mode
    std::string policy;
  };

  /// A call that is not answered within `deadline` is a PeerFault. `memory` must outlive the cast.
  LiveNodes(const Services& services, std::chrono::milliseconds deadline, WorldMemory& memory);

  /// In each role.
  struct Simulators {
    WorldRequest reference;
    WorldRequest engine;
  };

  /// Connects to all, the first time or after a fault, takes the worlds over, and sets their parameters: of a world
  /// whose kind is left open, on top of what it was before any run changed it. Each may take as long to appear as
  /// Peer::connect() says. Throws NodeMissing if one does not, PeerFault if one is lost meanwhile; the error of one
  /// that failed at start; InvalidInput if the two worlds of the engine differ, two worlds are one, a world's parameter
  /// on the parameter server is not the one that it works with, or the policy is none; BadDependency if one has come
  /// back as another.
  void connect(const Simulators& simulators, const pusht::Peer::Wait& wait);

  /// Makes ready for an episode. Throws PeerFault if a node has been replaced.
  void announce(int episode, int horizon);

  /// From now until the next announcement nobody sees what the worlds do, nor do stamps grow.
  void silence();

  /// An episode counts if this does not throw at its end: PeerFault if a world has been replaced, RuntimeFault if
  /// another caller has configured one.
  void requireUndisturbed();

  const pusht_msgs::DescribeResponse& describe(Mode mode) const { return world_nodes_.at(mode).description; }
  const pusht_msgs::DescribeResponse& describePolicy() const { return policy_peer_.description(); }

  const Worlds& worlds() const { return worlds_; }
  pusht::Policy& policy() { return *policy_; }
  pusht::StampSource& stamps() { return stamps_; }

 private:
  /// One world.
  struct WorldNode {
    pusht::Peer peer;
    pusht_msgs::DescribeResponse description;  // with the parameters as set
    pusht::ServedSimulator* world = nullptr;
  };

  void connectWorlds(const Simulators& simulators, const pusht::Peer::Wait& wait);
  void requireThreeWorlds() const;
  void requireOneEngine() const;

  WorldMemory& memory_;
  pusht::Watchdog watchdog_;
  pusht::StampSource stamps_;
  std::array<WorldNode, kModeCount> world_nodes_;
  pusht::Peer policy_peer_;
  Worlds worlds_;
  std::unique_ptr<pusht::ServedPolicy> policy_;
  std::optional<std::string> identity_;  // of all, as first connected to
};

}  // namespace sim2sim
