// SPDX-License-Identifier: BSD-3-Clause
/// Any simulator or policy as a node.
#pragma once

#include <functional>
#include <string>

#include "pusht_task/ros/parameters.hpp"
#include "pusht_task/ros/policy_session.hpp"
#include "pusht_task/ros/simulator_session.hpp"

namespace pusht {

/// The main of a simulator node. Offers, in its private namespace, the services `reset`, `step`, `configure` and
/// `describe`, the topics `state` and (latched) `markers`; TF `<frame_prefix>/table` to `pusher` and `tee`, and
/// (static) to `target`; /diagnostics. Markers and frames come again once a second. Private parameters: `frame_prefix`
/// (default: the node's name), `working_directory` (where relative paths begin), and the kind's own. If the kind cannot
/// be loaded with them, the node lives on, and only `describe` answers, with the error.
int serveSimulator(int argc, char** argv, const std::string& node_name, const SimulatorKind& kind);

/// The main of a node for every installed kind. The private parameter `kind` names the first one, and `configure` can
/// make it another one. `kind` and the parameters of the node follow, so that a node that is started again comes back
/// as it was. The rest is as in serveSimulator().
int serveAnySimulator(int argc, char** argv, const std::string& node_name);

/// The main of a policy node: services `act` and `describe`; /diagnostics. Failing at start: as above.
int servePolicy(int argc, char** argv, const std::string& node_name,
                const std::function<PolicyModel(ParameterReader&)>& load);

}  // namespace pusht
