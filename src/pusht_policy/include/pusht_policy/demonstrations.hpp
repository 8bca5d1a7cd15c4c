// SPDX-License-Identifier: BSD-3-Clause
/// Demonstrations as a rosbag: training data of a policy.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "pusht_task/policy.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

constexpr const char* kDemonstrationOriginTopic = "/demonstration/origin";  ///< std_msgs/String: JSON; once
constexpr const char* kDemonstrationWorldTopic = "/demonstration/world";    ///< pusht_msgs/DemonstrationWorld
constexpr const char* kDemonstrationStepTopic = "/demonstration/step";      ///< pusht_msgs/DemonstrationStep
constexpr const char* kDemonstrationEndTopic = "/demonstration/end";        ///< pusht_msgs/DemonstrationEnd

/// Parameters of a recording of demonstrations.
struct DemonstrationPlan {
  std::reference_wrapper<const Task> task = fullCircle();
  std::uint64_t seed = 0;  ///< demonstration i starts from spawn seed + i
  int episodes = 500;
  /// Standard deviation of the normal noise on each axis of the actions that the world takes [unit of an action]; the
  /// bag has the demonstrator's own. So it shows how to recover. Source: M. Laskey et al., "DART: Noise Injection for
  /// Robust Imitation Learning" (2017), there with a deviation that is fitted to the learner.
  double action_noise = 0.0;

  /// Throws InvalidInput with field, value and rule.
  void validate() const;
};

/// World of a demonstration.
struct DemonstrationWorld {
  std::shared_ptr<Simulator> world;
  std::string simulator;                                     ///< as a plan names it: "mujoco:timestep=0.005"
  std::vector<std::pair<std::string, std::string>> drawn{};  ///< names and values of parameters drawn for it
};

/// World of the demonstration from this spawn seed. It may be that of another demonstration, too.
using DemonstrationWorlds = std::function<DemonstrationWorld(std::uint64_t seed)>;

/// Counts of recorded demonstrations.
struct DemonstrationTally {
  int episodes = 0;
  int successes = 0;
  std::int64_t frames = 0;
};

/// Lets `demonstrator` solve the task in the `worlds` and records every control step into a bag, which appears at
/// `path` when it is complete. The bag begins with `origin` (demonstrator, simulators), to which its format and the
/// noise are added. `report` is called after every episode; it returns whether to continue. Throws InvalidInput if
/// there is something at `path`, RuntimeFault if `report` returned false or the bag cannot be written.
DemonstrationTally recordDemonstrations(const DemonstrationPlan& plan, const DemonstrationWorlds& worlds,
                                        Policy& demonstrator, const nlohmann::json& origin,
                                        const std::filesystem::path& path,
                                        const std::function<bool(const DemonstrationTally&)>& report);

}  // namespace pusht
