// SPDX-License-Identifier: BSD-3-Clause
/// Main functions of nodes that serve a simulator. Apart, because these few lines need no header of ROS.
#pragma once

#include <string>

namespace pusht {

struct SimulatorKind;

/// Main of a simulator node of one kind. Offers, in its private namespace, the services `reset`, `step`, `configure`
/// and `describe`, the topics `state` and (latched) `markers`; TF `<frame_prefix>/table` to `pusher` and `tee`, and
/// (static) to `target`; /diagnostics. Markers and frames come again once a second. Private parameters: `frame_prefix`
/// (default: the node's name), `working_directory` (where relative paths begin), and the kind's own. If the kind cannot
/// be loaded with them, the node lives on, and only `describe` answers, with the error.
int serveSimulator(int argc, char** argv, const std::string& node_name, const SimulatorKind& kind);

/// Main of a simulator node for every installed kind. The private parameter `kind` names the first one. The service
/// `configure` can change it to another. `kind` and the node's parameters follow, so a restarted node comes back as it
/// was. It fails as serveSimulator() does.
int serveAnySimulator(int argc, char** argv, const std::string& node_name);

}  // namespace pusht
