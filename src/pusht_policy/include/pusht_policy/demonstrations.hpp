// SPDX-License-Identifier: BSD-3-Clause
/// Demonstrations as a rosbag: what a policy is trained on.
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

/// Lets `demonstrator` solve the task in `world` and records every control step into the bag at `path`,
/// which appears there when it is complete and begins with their `origin`: which demonstrator, which simulator. The
/// format of the bag is added to it. Throws InvalidInput if there is something already. `report` is called after every
/// episode; returning false ends the collection with RuntimeFault, as does a failure to write.
DemonstrationTally recordDemonstrations(const DemonstrationPlan& plan, Simulator& world, Policy& demonstrator,
                                        const nlohmann::json& origin, const std::filesystem::path& path,
                                        const std::function<bool(const DemonstrationTally&)>& report);

}  // namespace pusht
