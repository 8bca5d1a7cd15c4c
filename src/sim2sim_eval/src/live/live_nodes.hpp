// SPDX-License-Identifier: BSD-3-Clause
/// Nodes of a live run.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "live/world_memory.hpp"
#include "sim2sim_protocol/flight.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_serving/peer.hpp"
#include "sim2sim_serving/remote_policy.hpp"
#include "sim2sim_serving/remote_simulator.hpp"

namespace sim2sim {

/// Connections to three served worlds and a served policy. Kind, version, parameters and provenance of each node are
/// fixed by the first connection; a node that comes back after a fault must have the same. Not thread-safe.
class LiveNodes {
 public:
  /// Service namespaces of the nodes of a run.
  struct Services {
    std::array<std::string, kModeCount> worlds;  ///< service namespaces, by mode
    std::string policy;
  };

  /// Each call must be answered within `deadline`, or throws PeerFault. `memory` must outlive this object.
  LiveNodes(const Services& services, std::chrono::milliseconds deadline, WorldMemory& memory);

  /// Requested kinds and parameters of the simulators.
  struct Simulators {
    WorldRequest reference;
    WorldRequest engine;
    std::reference_wrapper<const pusht::Task> task = pusht::fullCircle();
  };

  /// Connects to all nodes, the first time or after a fault, takes the worlds over, and sets their kinds and
  /// parameters. A world whose kind is left open keeps the kind and parameters from before any run changed it
  /// (WorldMemory), with the requested parameters on top. Waits for each node as Peer::connect() with `wait`.
  ///
  /// Throws NodeMissing if a node does not appear; PeerFault if one is lost meanwhile; the error of a node that failed
  /// at its start; InvalidInput if the two worlds of the engine differ, two worlds are one node, a parameter on the
  /// parameter server differs from the one in force, or the policy's node is a simulator or acts in another task;
  /// BadDependency if a node has come back with other properties.
  void connect(const Simulators& simulators, const pusht::Peer::Wait& wait);

  /// Announces an episode of at most `horizon` control steps to all worlds. Throws PeerFault if a node was replaced.
  void announce(int episode, int horizon);

  /// Silences the worlds until the next announcement: they publish nothing, and stamps do not grow. For probes.
  void silence();

  /// Throws PeerFault if a world was replaced since the announcement, RuntimeFault if another caller has configured
  /// one. An episode counts only if this passes at its end.
  void requireUndisturbed();

  /// Description of a world, with its parameters in force.
  const pusht_msgs::DescribeResponse& describe(Mode mode) const { return world_nodes_.at(mode).description; }
  const pusht_msgs::DescribeResponse& describePolicy() const { return policy_peer_.description(); }

  const Worlds& worlds() const { return worlds_; }
  pusht::Policy& policy() { return *policy_; }
  pusht::StampSource& stamps() { return stamps_; }

 private:
  /// Connection to a world.
  struct WorldNode {
    pusht::Peer peer;
    pusht_msgs::DescribeResponse description;  // with the parameters as set
    pusht::RemoteSimulator* world = nullptr;
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
  std::unique_ptr<pusht::Policy> policy_;  // in the loops of both roles
  std::optional<std::string>
      identity_;  // name, version, parameters and provenance of all nodes at the first connection
};

}  // namespace sim2sim
