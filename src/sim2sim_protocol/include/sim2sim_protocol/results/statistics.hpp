// SPDX-License-Identifier: BSD-3-Clause
/// statistics.json: the headline of a run, and the distribution of every quantity in every rollout.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// Content of statistics.json, from at least one episode: number of episodes that have a quantity, its mean, standard
/// deviation, median and quantiles, in its unit; first divergences of each rollout.
nlohmann::json statistics(const RunConfiguration& configuration, const std::vector<EpisodeResult>& episodes);

}  // namespace sim2sim
