// SPDX-License-Identifier: BSD-3-Clause
/// Matrix of a finished sweep over policies. Work of `rosrun sim2sim_eval matrix`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Options of the command `matrix`.
struct MatrixOptions {
  std::filesystem::path sweep;       ///< folder of the sweep, from a plan with `policies`
  std::vector<std::string> groups;   ///< whose policies are in the matrix; empty: all policies
  std::filesystem::path hypotheses;  ///< YAML file for readHypotheses(); empty: none
  bool overwrite = false;            ///< replace a matrix that is in the folder

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Prints the matrix of a sweep, and writes matrix.json and matrix.csv into its folder: both, or none. Throws
/// InvalidInput if one of them is there and must stay; as readMatrix(), test() and readHypotheses()
/// otherwise.
void matrix(const MatrixOptions& options);

}  // namespace sim2sim
