// SPDX-License-Identifier: BSD-3-Clause
/// Demonstrations of the scripted expert, as training data. Work of the command `demonstrate`.
#pragma once

#include <string>
#include <vector>

#include "pusht_policy/demonstrations.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// Options of the command `demonstrate`.
struct DemonstrateOptions {
  pusht::DemonstrationPlan plan;
  std::vector<std::string> simulators = {kCourseReference};  ///< for DemonstrationSimulators, as are the settings
  std::vector<std::string> settings;
  std::string out = "demonstrations.bag";  ///< bag to write; must not be there
};

/// Records the demonstrations and prints how many the expert has solved. Throws as
/// pusht::recordDemonstrations() and DemonstrationSimulators; an interruption leaves no bag.
void demonstrate(const DemonstrateOptions& options);

}  // namespace sim2sim
