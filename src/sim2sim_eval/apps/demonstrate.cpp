// SPDX-License-Identifier: BSD-3-Clause
#include "batch/demonstrate.hpp"

#include "sim2sim_eval/batch/command_line.hpp"

int main(int argc, char** argv) {
  sim2sim::DemonstrateOptions options;
  return sim2sim::runCommand(
      "demonstrate", "Records demonstrations of the scripted expert as a rosbag.", argc, argv,
      [&](CLI::App& app) { options.declare(app); }, [&] { sim2sim::demonstrate(options); });
}
