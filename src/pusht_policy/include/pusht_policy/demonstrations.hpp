// SPDX-License-Identifier: BSD-3-Clause
/// Demonstrations as a rosbag: training data of a policy.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>

#include "pusht_task/policy.hpp"
#include "pusht_task/simulator.hpp"

namespace pusht {

constexpr const char* kDemonstrationOriginTopic = "/demonstration/origin";  ///< std_msgs/String: JSON; once
constexpr const char* kDemonstrationStepTopic = "/demonstration/step";      ///< pusht_msgs/DemonstrationStep
constexpr const char* kDemonstrationEndTopic = "/demonstration/end";        ///< pusht_msgs/DemonstrationEnd

/// Parameters of a recording of demonstrations.
struct DemonstrationPlan {
  std::uint64_t seed = 0;  ///< demonstration i starts from spawn seed + i
  int episodes = 500;

  /// Throws InvalidInput with field, value and rule.
  void validate() const;
};

/// Counts of recorded demonstrations.
struct DemonstrationTally {
  int episodes = 0;
  int successes = 0;
  std::int64_t frames = 0;
};

/// Lets `demonstrator` solve the task in `world` and records every control step into a bag, which appears at `path`
/// when it is complete. The bag begins with `origin` (demonstrator, simulator), to which its format is added. `report`
/// is called after every episode; it returns whether to continue. Throws InvalidInput if there is something at `path`,
/// RuntimeFault if `report` returned false or the bag cannot be written.
DemonstrationTally recordDemonstrations(const DemonstrationPlan& plan, Simulator& world, Policy& demonstrator,
                                        const nlohmann::json& origin, const std::filesystem::path& path,
                                        const std::function<bool(const DemonstrationTally&)>& report);

}  // namespace pusht
