// SPDX-License-Identifier: BSD-3-Clause
/// Demonstrations of the scripted expert in MuJoCo, as training data. Work of `rosrun sim2sim_eval demonstrate`.
#pragma once

#include <string>

#include "pusht_policy/demonstrations.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Options of the command `demonstrate`.
struct DemonstrateOptions {
  pusht::DemonstrationPlan plan;
  std::string out = "demonstrations.bag";  ///< bag to write; must not be there

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Records the demonstrations and prints how many the expert has solved. Throws as pusht::recordDemonstrations(); an
/// interruption leaves no bag.
void demonstrate(const DemonstrateOptions& options);

}  // namespace sim2sim
