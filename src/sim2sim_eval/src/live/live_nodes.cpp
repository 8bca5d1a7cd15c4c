// SPDX-License-Identifier: BSD-3-Clause
#include "live/live_nodes.hpp"

#include <algorithm>
#include <utility>

#include "pusht_task/error.hpp"

namespace sim2sim {
namespace {

using pusht_msgs::DescribeResponse;

std::string textOf(const pusht::Parameters& parameters) {
  std::string text;
  for (const pusht_msgs::Parameter& parameter : parameters) {
    text += (text.empty() ? "" : ", ") + parameter.name + " " + parameter.value;
  }
  return text;
}

/// Identity of a node: all that its numbers depend on.
std::string identityOf(const DescribeResponse& node) {
  return node.name + " " + node.version + " (" + textOf(node.parameters) + ") " + node.provenance;
}

/// A parameter that is set on the parameter server has no effect on a node that runs: it may not be overlooked.
void requireParametersInForce(const std::string& services, const DescribeResponse& node) {
  for (const pusht_msgs::Parameter& parameter : node.parameters) {
    const std::optional<std::string> set = pusht::storedText(services + "/" + parameter.name);
    const bool free_text = std::holds_alternative<std::string>(pusht::valueOf(parameter.value));  // may be a path
    if (set && !free_text && !pusht::sameValue(*set, parameter.value)) {
      throw pusht::InvalidInput("parameter " + services + "/" + parameter.name + " " + *set + ": the node works with " +
                                parameter.value + "; set it with " + services +
                                "/configure, in the goal, or before the node is started");
    }
  }
}

void requireIsPolicy(const pusht::Peer& peer, const pusht::Task& task) {
  const DescribeResponse& node = peer.description();
  if (!node.frame_prefix.empty()) {
    throw pusht::InvalidInput(peer.services() + ": is the simulator '" + node.name + "', must be a policy");
  }
  const std::string said = pusht::taskIn(node.parameters).value_or(pusht::fullCircle().name);
  const pusht::Task& acts_in = pusht::taskNamed(said);
  if (&acts_in != &task) {
    throw pusht::InvalidInput(peer.services() + ": acts in the task " + acts_in.name + ": must in " + task.name +
                              "; start it with the parameter task");
  }
}

}  // namespace

LiveNodes::LiveNodes(const Services& services, std::chrono::milliseconds deadline, WorldMemory& memory)
    : memory_(memory),
      watchdog_(deadline),
      world_nodes_{WorldNode{{services.worlds[kReferenceClosed], watchdog_}, {}, nullptr},
                   WorldNode{{services.worlds[kEngineClosed], watchdog_}, {}, nullptr},
                   WorldNode{{services.worlds[kEngineReplay], watchdog_}, {}, nullptr}},
      policy_peer_(services.policy, watchdog_) {}

void LiveNodes::connect(const Simulators& simulators, const pusht::Peer::Wait& wait) {
  connectWorlds(simulators, wait);
  policy_peer_.connect(wait);
  requireIsPolicy(policy_peer_, simulators.task);
  policy_ = pusht::looped(std::make_unique<pusht::RemotePolicy>(policy_peer_), loopOf(simulators.reference),
                          loopOf(simulators.engine), simulators.task);
  requireThreeWorlds();
  requireOneEngine();

  std::string identity = identityOf(policy_peer_.description());
  for (const WorldNode& node : world_nodes_) {
    identity += "; " + identityOf(node.description);
  }
  if (identity_ && *identity_ != identity) {
    throw pusht::BadDependency("the nodes have come back as " + identity + "; must be " + *identity_);
  }
  identity_ = std::move(identity);
}

void LiveNodes::connectWorlds(const Simulators& simulators, const pusht::Peer::Wait& wait) {
  worlds_ = {};  // leaves those that have not been lost
  std::array<std::unique_ptr<pusht::Simulator>, kModeCount> worlds;
  for (std::size_t mode = 0; mode < kModeCount; ++mode) {
    WorldNode& node = world_nodes_.at(mode);
    node.peer.connect(wait);
    const std::string& services = node.peer.services();
    const pusht_msgs::DescribeResponse& now = node.peer.description();
    const WorldRequest& asked = mode == kReferenceClosed ? simulators.reference : simulators.engine;
    WorldRequest wanted = requestFor(node.description);  // as before
    if (!identity_) {
      requireParametersInForce(services, now);
      wanted = memory_.resolve(services, now, ofWorld(asked));
    }
    std::unique_ptr<pusht::RemoteSimulator> world;
    try {
      world =
          std::make_unique<pusht::RemoteSimulator>(node.peer, stamps_, wanted.kind, wanted.parameters, simulators.task);
    } catch (const pusht::Error& error) {
      if (error.exitCode() == pusht::ExitCode::kInvalidInput) {  // a refused configuration changes nothing
        memory_.configured(services, now);
      }
      throw;
    }
    node.description = world->describe();  // not before: a node that dies meanwhile gets what was asked for next time
    memory_.configured(services, node.description);
    node.world = world.get();
    worlds.at(mode) = std::move(world);
  }
  worlds_ =
      worldsOf(std::move(worlds[kReferenceClosed]), std::move(worlds[kEngineClosed]), std::move(worlds[kEngineReplay]));
}

void LiveNodes::requireThreeWorlds() const {
  for (std::size_t a = 0; a < kModeCount; ++a) {
    for (std::size_t b = a + 1; b < kModeCount; ++b) {
      if (world_nodes_.at(a).description.instance_id == world_nodes_.at(b).description.instance_id) {
        throw pusht::InvalidInput(world_nodes_.at(a).peer.services() + " and " + world_nodes_.at(b).peer.services() +
                                  " are one node: each rollout needs a world of its own");
      }
    }
  }
}

void LiveNodes::requireOneEngine() const {
  const std::string closed = identityOf(world_nodes_[kEngineClosed].description);
  const std::string replay = identityOf(world_nodes_[kEngineReplay].description);
  if (closed != replay) {
    throw pusht::InvalidInput(world_nodes_[kEngineReplay].peer.services() + " is " + replay + ": must be as " +
                              world_nodes_[kEngineClosed].peer.services() + ", " + closed);
  }
}

void LiveNodes::announce(int episode, int horizon) {
  policy_peer_.requireSameOwner();
  for (WorldNode& node : world_nodes_) {
    node.peer.requireSameOwner();
    node.world->announce(static_cast<std::uint64_t>(episode), horizon);
  }
}

void LiveNodes::silence() {
  for (WorldNode& node : world_nodes_) {
    node.world->silence();
  }
}

void LiveNodes::requireUndisturbed() {
  for (WorldNode& node : world_nodes_) {
    node.world->describe();
  }
}

}  // namespace sim2sim
