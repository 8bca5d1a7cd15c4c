// SPDX-License-Identifier: BSD-3-Clause
/// The comparison in process: what `rosrun sim2sim_eval compare` does.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "pusht_engine/two_mass_engine.hpp"

namespace sim2sim {

struct CompareOptions {
  std::string policy = "bc";  ///< a TorchScript file, or "bc" (the shipped one), or "expert"
  bool require_policy = false;
  int episodes = 50;
  std::uint64_t seed = 0;
  pusht::TwoMassParameters knobs;
  bool smoke = false;
  std::string scene;  ///< MJCF file; empty: the installed one
  std::string out;    ///< results folder; empty: the next free results/compare-N
  bool overwrite = false;

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Runs the protocol, writes the results folder and prints the table. Throws an Error of its kind on failure;
/// finished episodes are kept then.
void compare(const CompareOptions& options);

}  // namespace sim2sim
