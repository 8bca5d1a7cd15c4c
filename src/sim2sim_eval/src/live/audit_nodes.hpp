// SPDX-License-Identifier: BSD-3-Clause
/// Audit of two simulators that are nodes. Work of audit.launch.
#pragma once

#include "pusht_task/error.hpp"

namespace sim2sim {

/// Body of the node `audit`: audits the world `engine` against the world `reference`, prints the result, and writes it
/// where `out` says. Model variants of the reference run in this process, if the reference is a kind that is installed.
/// Returns kOk. Throws ContractError if the contract is broken; InvalidInput for parameters that are not valid;
/// RuntimeFault if a node is missing. A node that is lost later says so in the experiments that need it.
pusht::ExitCode auditNodes();

}  // namespace sim2sim
