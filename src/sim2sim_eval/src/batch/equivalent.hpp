// SPDX-License-Identifier: BSD-3-Clause
/// Equivalents of a gap. Work of `rosrun sim2sim_eval equivalent`.
#pragma once

#include <string>

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Command line of `equivalent`.
struct EquivalentOptions {
  std::string sweep;  ///< folder of a sweep over engines and errors of the reference
  bool overwrite = false;

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Prints the equivalents of each engine of the sweep, and writes equivalent.json and equivalent.csv into its folder.
/// Throws as readEquivalents() and DerivedFiles.
void equivalent(const EquivalentOptions& options);

}  // namespace sim2sim
