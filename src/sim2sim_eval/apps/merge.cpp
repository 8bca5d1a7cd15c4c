// SPDX-License-Identifier: BSD-3-Clause
#include "batch/merge.hpp"

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  sim2sim::MergeOptions options;
  return sim2sim::runCommand(
      "merge", "Joins the shards of a sweep; the results are those of the sweep in one piece, byte for byte.", argc,
      argv, [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::merge(options); });
}
