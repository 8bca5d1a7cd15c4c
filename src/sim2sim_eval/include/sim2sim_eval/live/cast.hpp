// SPDX-License-Identifier: BSD-3-Clause
/// The nodes that play in a live run.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "pusht_task/ros/peer.hpp"
#include "pusht_task/ros/served_policy.hpp"
#include "pusht_task/ros/served_simulator.hpp"
#include "sim2sim_eval/protocol/protocol.hpp"

namespace sim2sim {

/// Three served worlds and a served policy. What they are is fixed when they are first connected to: a node
/// that comes back after a fault must be the same again.
class Cast {
 public:
  struct Services {
    std::array<std::string, kModeCount> worlds;  ///< service namespaces, by mode
    std::string policy;
  };

  /// A call that is not answered within `deadline` is a PeerFault.
  Cast(const Services& services, std::chrono::milliseconds deadline);

  /// What a world becomes.
  struct Setting {
    std::string kind{};              ///< of simulator; empty: it stays what it is
    pusht::Parameters parameters{};  ///< the others keep their values; of a kind that is named, they have its defaults
  };

  /// In each role.
  struct Settings {
    Setting reference;
    Setting engine;
  };

  /// Connects to all, the first time or after a fault, takes the worlds over, and sets their parameters. Each may
  /// take as long to appear as Peer::connect() says. Throws RuntimeFault if one does not, PeerFault if one is lost
  /// meanwhile; the error of one that failed at start; InvalidInput if the two worlds of the engine differ or two
  /// worlds are one; BadDependency if one has come back as another.
  void connect(const Settings& settings, std::chrono::milliseconds patience, bool respawn,
               const std::function<bool()>& stop);

  /// Makes ready for an episode. Throws PeerFault if a node has been replaced.
  void announce(int episode, int horizon);

  /// From now until the next announcement nobody sees what the worlds do, nor do stamps grow.
  void silence();

  /// An episode counts if this does not throw at its end: PeerFault if a world has been replaced, RuntimeFault if
  /// another caller has configured one.
  void requireUndisturbed();

  const pusht_msgs::DescribeResponse& describe(Mode mode) const { return parts_.at(mode).description; }
  const pusht_msgs::DescribeResponse& describePolicy() const { return policy_peer_.description(); }

  const Worlds& worlds() const { return worlds_; }
  pusht::Policy& policy() { return *policy_; }
  pusht::StampSource& stamps() { return stamps_; }

 private:
  /// One world.
  struct Part {
    pusht::Peer peer;
    pusht_msgs::DescribeResponse description;  // with the parameters as set
    pusht::ServedSimulator* world = nullptr;
  };

  void connectWorlds(const Settings& settings, std::chrono::milliseconds patience, bool respawn,
                     const std::function<bool()>& stop);
  void requireThreeWorlds() const;
  void requireOneEngine() const;

  pusht::Watchdog watchdog_;
  pusht::StampSource stamps_;
  std::array<Part, kModeCount> parts_;
  pusht::Peer policy_peer_;
  Worlds worlds_;
  std::unique_ptr<pusht::ServedPolicy> policy_;
  std::optional<std::string> identity_;  // of all, as first connected to
};

}  // namespace sim2sim
