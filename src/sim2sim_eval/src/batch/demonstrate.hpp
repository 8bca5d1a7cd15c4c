// SPDX-License-Identifier: BSD-3-Clause
/// Demonstrations of an expert, as training data. Work of the command `demonstrate`.
#pragma once

#include <string>
#include <vector>

#include "pusht_policy/demonstrations.hpp"
#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// Options of the command `demonstrate`.
struct DemonstrateOptions {
  pusht::DemonstrationPlan plan;
  std::string task = pusht::fullCircle().name;               ///< as for taskNamed()
  std::string demonstrator = pusht::kExpertPolicy;           ///< or kPlannerPolicy
  std::vector<std::string> simulators = {kCourseReference};  ///< for DemonstrationSimulators, as are the settings
  std::vector<std::string> settings;
  std::string out = "demonstrations.bag";  ///< bag to write; must not be there
};

/// Records the demonstrations and prints how many are solved. Throws as choosePolicy(),
/// pusht::recordDemonstrations() and DemonstrationSimulators; an interruption leaves no bag.
void demonstrate(const DemonstrateOptions& options);

}  // namespace sim2sim
