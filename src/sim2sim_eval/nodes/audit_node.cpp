// SPDX-License-Identifier: BSD-3-Clause
/// Audit of two worlds that are nodes.
#include "live/audit_nodes.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_serving/node.hpp"

int main(int argc, char** argv) {
  sim2sim::catchInterruptsAside("audit");
  return pusht::runNode(argc, argv, "audit", pusht::NoMaster::kFail, sim2sim::auditNodes, pusht::Life::kRunsOnce);
}
