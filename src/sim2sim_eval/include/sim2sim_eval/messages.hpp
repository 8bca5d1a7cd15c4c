// SPDX-License-Identifier: BSD-3-Clause
/// A run as messages.
#pragma once

#include <pusht_msgs/Divergence.h>
#include <pusht_msgs/EpisodeResult.h>
#include <pusht_msgs/Summary.h>
#include <ros/time.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "pusht_task/ros/parameters.hpp"
#include "sim2sim_eval/protocol.hpp"
#include "sim2sim_eval/report.hpp"

namespace sim2sim {

/// Of the states after `step` control steps. NaN where a rollout has ended before.
pusht_msgs::Divergence divergenceMessage(const Episode& episode, int step, const ros::Time& stamp);

pusht_msgs::EpisodeResult toMessage(const EpisodeResult& episode, const ros::Time& stamp);

/// Of a run with the summary of its `finished` episodes, if there are any.
pusht_msgs::Summary summaryMessage(const RunConfiguration& configuration, const std::optional<Summary>& finished,
                                   const ros::Time& stamp);

/// The knobs of a served simulator as a RunConfiguration has them, each of the type that its text shows.
nlohmann::ordered_json knobsFrom(const pusht::Parameters& parameters);

}  // namespace sim2sim
