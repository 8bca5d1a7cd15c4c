// SPDX-License-Identifier: BSD-3-Clause
/// Channels over roscpp to the nodes of a comparison and to the master. Presence and answers come as events.
#pragma once

#include <pusht_msgs/ControlRequest.h>

#include <cstdint>
#include <memory>
#include <string>

#include "events.hpp"
#include "nodes.hpp"
#include "service_channel.hpp"

namespace pusht_rviz {

/// To `control` of an evaluator.
std::unique_ptr<ServiceChannel> controlChannel(const std::string& evaluator, const std::shared_ptr<Events>& events);

/// To `service`, the `describe` of a node, which describes itself at each heartbeat.
std::unique_ptr<ServiceChannel> nodeChannel(const std::string& service, const std::shared_ptr<Events>& events,
                                            Node node);

/// To `episodes` of an evaluator. It asks once, by itself, and pushes an EpisodesEvent with the number `request`. It is
/// apart from the control channel because ten thousand episodes take a while, and commands must not wait for them.
std::unique_ptr<ServiceChannel> episodesChannel(const std::string& evaluator, const std::shared_ptr<Events>& events,
                                                std::uint64_t request);

/// To the master: a MasterEvent every two seconds.
std::unique_ptr<ServiceChannel> masterChannel(const std::shared_ptr<Events>& events);

/// Calls for ServiceChannel::ask(): of a control channel, and of a node channel about a kind of simulator.
ServiceChannel::Call controlCall(const std::shared_ptr<Events>& events, const pusht_msgs::ControlRequest& request);
/// Call for ServiceChannel::ask() of a node channel about a kind of simulator.
ServiceChannel::Call describeCall(const std::shared_ptr<Events>& events, Node node, const std::string& kind);

}  // namespace pusht_rviz
