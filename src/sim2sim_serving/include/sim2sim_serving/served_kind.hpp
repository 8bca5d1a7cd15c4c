// SPDX-License-Identifier: BSD-3-Clause
/// Kind of simulator that is what a node serves.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// Time limits of the calls to a node, by the steady clock.
struct NodeTimes {
  std::chrono::milliseconds deadline{5'000};   ///< for each answer
  std::chrono::milliseconds patience{30'000};  ///< for a node that is not there, or not there any more
};

/// What a node serves, as a kind. Its libraries are empty: `code` stands for them.
struct ServedKind {
  SimulatorKind kind;   ///< name, version, parameters as the node describes them
  nlohmann::json code;  ///< what the node says of its code, whatever its parameters: name, version, provenance
};

/// Kind of the simulator that the node of the namespace `services` serves. Makes this process a node.
///
/// The node has one world, so of all models of the kind there must be one world at a time. load() asks the node what it
/// makes of the parameters, once for each setting; those that are not set have the defaults that the node describes
/// (numbers of a task: the task's), whatever it works with. A world takes the node over and sets all parameters. A node
/// that was lost may come back for the next world, as what it was: after a wait in vain, further ones are short.
///
/// Waits end when `stop` holds. Throws RuntimeFault then, and if there is no master; NodeMissing if the node is not
/// there; InvalidInput for a name that is not valid, a policy, or a node of another type; BadDependency if the node
/// does not describe its parameters, or as Peer::connect(). load() also throws the error with which the node refuses; a
/// world throws BadDependency if the node has changed its version, PeerFault if it is lost, RuntimeFault if another
/// caller has taken it, and SimulationFault with the node's words if it refuses a step.
ServedKind servedKind(const std::string& services, const NodeTimes& times, std::function<bool()> stop);

}  // namespace pusht
