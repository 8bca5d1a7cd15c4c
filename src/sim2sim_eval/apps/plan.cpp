// SPDX-License-Identifier: BSD-3-Clause
#include "batch/plan.hpp"

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  sim2sim::PlanOptions options;
  return sim2sim::runCommand(
      "plan", "Says how small a difference a run can show, from how much the episodes of a finished run vary.", argc,
      argv, [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::plan(options); });
}
