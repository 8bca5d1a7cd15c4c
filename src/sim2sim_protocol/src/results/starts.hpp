// SPDX-License-Identifier: BSD-3-Clause
/// Episodes of a run by start: the unit of all its intervals and tests. Without repeats each episode has a start of its
/// own, and is the unit itself.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_statistics/pairs.hpp"
#include "sim2sim_statistics/repeats.hpp"

namespace sim2sim {

/// Episodes of each start, in their order; `episodes` in index order. A run that has not finished may lack some.
std::vector<std::vector<const EpisodeResult*>> byStart(const Protocol& protocol,
                                                       const std::vector<EpisodeResult>& episodes);

/// Mean of a value over the episodes of each start, over those in which it is not NaN; without repeats the values.
std::vector<double> meansByStart(const Protocol& protocol, const std::vector<EpisodeResult>& episodes,
                                 const std::function<double(const EpisodeResult&)>& value);

/// A result for each start, whose quantities are means over its episodes, as meansByStart(). All else is that of the
/// first episode. Without repeats the episodes.
std::vector<EpisodeResult> meansOfStarts(const Protocol& protocol, const std::vector<EpisodeResult>& episodes);

/// Paired successes of two rollouts by start, of one run or of two runs over the same episodes.
std::vector<PairTable> pairsByStart(const Protocol& protocol, const std::vector<EpisodeResult>& first,
                                    std::size_t rollout_in_first, const std::vector<EpisodeResult>& second,
                                    std::size_t rollout_in_second);

/// Successes of a rollout by start.
std::vector<StartCount> successesByStart(const Protocol& protocol, const std::vector<EpisodeResult>& episodes,
                                         std::size_t rollout);

}  // namespace sim2sim
