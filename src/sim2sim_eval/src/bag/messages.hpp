// SPDX-License-Identifier: BSD-3-Clause
/// Conversions of a run's results into ROS messages, and of a node's description into its record.
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

/// Divergences from the reference after `step` control steps [m, rad]: of the replay, the closed loop, and a tee that
/// never moves. NaN where one of the two rollouts has ended before.
pusht_msgs::Divergence divergenceMessage(const Episode& episode, int step, const ros::Time& stamp);

/// Outcome and quantities of an episode, by rollout.
pusht_msgs::EpisodeResult toMessage(const Protocol& protocol, const EpisodeResult& episode, const ros::Time& stamp);

/// States of the probe `mode` in an episode.
pusht_msgs::Trace toMessage(const std::string& mode, int episode, const pusht::Trace& trace, const ros::Time& stamp);

/// Summary of a run so far. Without `finished`, which summarizes the finished episodes, its figures are NaN.
pusht_msgs::Summary summaryMessage(const RunConfiguration& configuration, const std::optional<Summary>& finished,
                                   const ros::Time& stamp);

/// Record of a served simulator: name, title, parameters. A parameter without a descriptor counts as changed. Throws as
/// pusht::provenanceOf().
SimulatorRecord recordOf(const pusht_msgs::DescribeResponse& node);

}  // namespace sim2sim
