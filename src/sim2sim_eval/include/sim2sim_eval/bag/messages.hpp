// SPDX-License-Identifier: BSD-3-Clause
/// A run as messages.
#pragma once

#include <pusht_msgs/DescribeResponse.h>
#include <pusht_msgs/Divergence.h>
#include <pusht_msgs/EpisodeResult.h>
#include <pusht_msgs/Summary.h>
#include <pusht_msgs/Trace.h>
#include <ros/time.h>

#include <optional>
#include <string>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"

namespace sim2sim {

/// Of the states after `step` control steps. NaN where a rollout has ended before.
pusht_msgs::Divergence divergenceMessage(const Episode& episode, int step, const ros::Time& stamp);

pusht_msgs::EpisodeResult toMessage(const Protocol& protocol, const EpisodeResult& episode, const ros::Time& stamp);

/// What a probe did.
pusht_msgs::Trace toMessage(const std::string& mode, int episode, const pusht::Trace& trace, const ros::Time& stamp);

/// Of a run with the summary of its `finished` episodes, if there are any.
pusht_msgs::Summary summaryMessage(const RunConfiguration& configuration, const std::optional<Summary>& finished,
                                   const ros::Time& stamp);

/// What a node says that its numbers depend on, its "version" among it. Throws BadDependency if that is no JSON object.
nlohmann::json provenanceOf(const pusht_msgs::DescribeResponse& node);

/// A served simulator as it describes itself; of one that does not say what its parameters are, none has its default.
/// Throws as provenanceOf().
SimulatorRecord recordOf(const pusht_msgs::DescribeResponse& node);

}  // namespace sim2sim
