// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/plan.hpp"

#include <CLI/CLI.hpp>

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  CLI::App app("Says how small a difference a run can show, from how much the episodes of a finished run vary.",
               "plan");
  sim2sim::PlanOptions options;
  options.declare(app);
  return sim2sim::runCommand(app, argc, argv, [&] { sim2sim::plan(options); });
}
