// SPDX-License-Identifier: BSD-3-Clause
#include "batch/audit.hpp"

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  sim2sim::AuditOptions options;
  return sim2sim::runCommand(
      "audit", "Says by experiments whether two simulators keep one contract, and in what physics they differ.", argc,
      argv, [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::auditSimulators(options); });
}
