// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/merge.hpp"

#include <CLI/CLI.hpp>

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  CLI::App app("Joins the shards of a sweep; the results are those of the sweep in one piece, byte for byte.", "merge");
  sim2sim::MergeOptions options;
  options.declare(app);
  return sim2sim::runCommand(app, argc, argv, [&] { sim2sim::merge(options); });
}
