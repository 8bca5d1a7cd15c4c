// SPDX-License-Identifier: BSD-3-Clause
/// Attribution of a finished sweep: the share of the gap that each true/false parameter of the engine explains. Work of
/// `rosrun sim2sim_eval attribute`.
#pragma once

#include <filesystem>

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Options of the command `attribute`.
struct AttributeOptions {
  std::filesystem::path sweep;     ///< folder of the sweep, over combinations of true/false parameters
  std::filesystem::path baseline;  ///< folder of a run over the same episodes, shown beside; empty: none
  bool overwrite = false;          ///< replace an attribution that is in the folder

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Prints the attribution of a sweep, and writes attribution.json and attribution.csv into its folder: both, or none.
/// Throws InvalidInput if one of them is there and must stay; as attribute(folder, baseline, go_on) otherwise.
void attribute(const AttributeOptions& options);

}  // namespace sim2sim
