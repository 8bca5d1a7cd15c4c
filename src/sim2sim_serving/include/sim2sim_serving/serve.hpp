// SPDX-License-Identifier: BSD-3-Clause
/// Main functions of nodes that serve a simulator (serve_simulator.hpp) or a policy.
#pragma once

#include <functional>
#include <string>

#include "sim2sim_serving/node_parameters.hpp"
#include "sim2sim_serving/policy_session.hpp"
#include "sim2sim_serving/serve_simulator.hpp"
#include "sim2sim_serving/simulator_session.hpp"

namespace pusht {

/// Main of a policy node: services `act` and `describe`; /diagnostics. If `load` fails, the node lives on, and only
/// `describe` answers, with the error.
int servePolicy(int argc, char** argv, const std::string& node_name,
                const std::function<PolicyModel(ParameterReader&)>& load);

}  // namespace pusht
