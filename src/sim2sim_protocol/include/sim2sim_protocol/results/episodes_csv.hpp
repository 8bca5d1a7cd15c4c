// SPDX-License-Identifier: BSD-3-Clause
/// episodes.csv: the measurements of every rollout.
#pragma once

#include <string>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Text of episodes.csv: a row for each episode and rollout of the protocol. Reals have the shortest text that reads
/// back as the same number.
std::string episodesCsv(const Protocol& protocol, const std::vector<EpisodeResult>& episodes);

/// Reads the text of episodesCsv(). Throws InvalidInput with the line if the text is anything else.
std::vector<EpisodeResult> episodesFromCsv(const Protocol& protocol, const std::string& text);

}  // namespace sim2sim
