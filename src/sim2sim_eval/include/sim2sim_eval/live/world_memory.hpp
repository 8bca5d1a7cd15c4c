// SPDX-License-Identifier: BSD-3-Clause
/// What served worlds were before the evaluator configured them.
#pragma once

#include <pusht_msgs/DescribeResponse.h>

#include <map>
#include <optional>
#include <string>

#include "pusht_task/ros/parameters.hpp"

namespace sim2sim {

/// Kind and parameters of a world that a run asks for.
struct WorldRequest {
  std::string kind{};              ///< of simulator; empty: it stays what it is
  pusht::Parameters parameters{};  ///< the others keep their values; of a kind that is named, they have its defaults
};

/// Keeps runs apart: a run that leaves a world's kind open gets the world as it was before any run changed it, never
/// with what the run before asked for. A world that another caller has configured meanwhile, or that was started
/// anew with other parameters, counts as it is then.
class WorldMemory {
 public:
  /// Makes `asked` definite for the world behind `services`, which is `now`. The world is about to be configured.
  WorldRequest resolve(const std::string& services, const pusht_msgs::DescribeResponse& now, const WorldRequest& asked);

  /// The run has made the world what it is `now`.
  void configured(const std::string& services, const pusht_msgs::DescribeResponse& now);

  /// What the world behind `services` was before any run changed it; empty if no run has met it.
  std::string kindOf(const std::string& services) const;

 private:
  struct State {
    std::string name;
    pusht::Parameters parameters;
  };
  struct World {
    WorldRequest original;      // makes it what it was
    std::optional<State> left;  // by a run; none while one configures it, or if that failed
  };

  std::map<std::string, World> worlds_;  // by namespace of their services
};

/// The shortest setting that makes a world what `now` describes: the parameters that are neither defaults nor set by
/// a preset. So a preset that is set on top of it sets what it would set in `now`.
WorldRequest requestFor(const pusht_msgs::DescribeResponse& now);

}  // namespace sim2sim
