// SPDX-License-Identifier: BSD-3-Clause
/// Memory of the kinds and parameters that served worlds had before the evaluator configured them.
#pragma once

#include <pusht_msgs/DescribeResponse.h>

#include <map>
#include <optional>
#include <string>

#include "pusht_task/loop.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace sim2sim {

/// Requested kind and parameters of a world; "loop.NAME" is a parameter of the loop in which the policy drives it.
struct WorldRequest {
  std::string kind{};              ///< kind of simulator; empty: the world keeps its kind
  pusht::Parameters parameters{};  ///< parameters not listed keep their values, or, with a kind, take its defaults
};

/// Request without the parameters of the loop, of which the world's node knows nothing.
WorldRequest ofWorld(const WorldRequest& asked);

/// Loop of a request. Throws as ParameterSet::set().
pusht::ParameterSet loopOf(const WorldRequest& asked);

/// Memory that keeps runs independent of each other. A run that leaves a world's kind open gets the world as it was
/// before any run changed it, not with the parameters of the previous run. A world that another caller has configured
/// meanwhile, or that was restarted with other parameters, is remembered anew as it is then. Not thread-safe.
class WorldMemory {
 public:
  /// Request that makes the world behind `services` what a run asks for with `asked`. `now` describes the world, which
  /// is configured next.
  WorldRequest resolve(const std::string& services, const pusht_msgs::DescribeResponse& now, const WorldRequest& asked);

  /// Records that a run has configured the world to be `now`.
  void configured(const std::string& services, const pusht_msgs::DescribeResponse& now);

  /// Kind that the world behind `services` had before any run changed it; empty for an unknown world.
  std::string kindOf(const std::string& services) const;

 private:
  struct State {
    std::string name;
    pusht::Parameters parameters;
  };
  struct World {
    WorldRequest original;      // restores the world
    std::optional<State> left;  // state in which a run left it; none while a run configures it, or if that failed
  };

  std::map<std::string, World> worlds_;  // by namespace of the services
};

/// Shortest request that makes a world what `now` describes: it lists the parameters that are neither defaults nor set
/// by a preset. So a preset on top of it sets the same parameters as it would in `now`.
WorldRequest requestFor(const pusht_msgs::DescribeResponse& now);

}  // namespace sim2sim
