// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/batch/demonstrate.hpp"

#include <CLI/CLI.hpp>

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  CLI::App app("Records demonstrations of the scripted expert as a rosbag.", "demonstrate");
  sim2sim::DemonstrateOptions options;
  options.declare(app);
  return sim2sim::runCommand(app, argc, argv, [&] { sim2sim::demonstrate(options); });
}
