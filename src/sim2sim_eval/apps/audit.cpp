// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/audit.hpp"

#include <CLI/CLI.hpp>

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  CLI::App app("Says by experiments whether two simulators keep one contract, and in what physics they differ.",
               "audit");
  sim2sim::AuditOptions options;
  options.declare(app);
  return sim2sim::runCommand(app, argc, argv, [&] { sim2sim::auditSimulators(options); });
}
