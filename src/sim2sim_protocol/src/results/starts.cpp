// SPDX-License-Identifier: BSD-3-Clause
#include "starts.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

/// Mean of the values that are not NaN; NaN without one.
double meanOfKnown(const std::vector<const EpisodeResult*>& episodes,
                   const std::function<double(const EpisodeResult&)>& value) {
  std::vector<double> known;
  for (const EpisodeResult* episode : episodes) {
    if (const double found = value(*episode); !std::isnan(found)) {
      known.push_back(found);
    }
  }
  return averageOf(known);
}

}  // namespace

std::vector<std::vector<const EpisodeResult*>> byStart(const Protocol& protocol,
                                                       const std::vector<EpisodeResult>& episodes) {
  std::vector<std::vector<const EpisodeResult*>> starts;
  int last = 0;
  for (const EpisodeResult& episode : episodes) {
    const int start = episode.index / protocol.repeats;
    if (starts.empty() || start != last) {
      starts.emplace_back();
    }
    starts.back().push_back(&episode);
    last = start;
  }
  return starts;
}

std::vector<double> meansByStart(const Protocol& protocol, const std::vector<EpisodeResult>& episodes,
                                 const std::function<double(const EpisodeResult&)>& value) {
  std::vector<double> means;
  if (protocol.repeats == 1) {
    std::transform(episodes.begin(), episodes.end(), std::back_inserter(means), value);
    return means;
  }
  for (const std::vector<const EpisodeResult*>& start : byStart(protocol, episodes)) {
    means.push_back(meanOfKnown(start, value));
  }
  return means;
}

std::vector<EpisodeResult> meansOfStarts(const Protocol& protocol, const std::vector<EpisodeResult>& episodes) {
  if (protocol.repeats == 1) {
    return episodes;
  }
  std::vector<EpisodeResult> means;
  for (const std::vector<const EpisodeResult*>& start : byStart(protocol, episodes)) {
    EpisodeResult& mean = means.emplace_back(*start.front());
    for (std::size_t rollout = 0; rollout < mean.rollouts.size(); ++rollout) {
      for (std::size_t i = 0; i < kQuantities.size(); ++i) {
        mean.rollouts[rollout].quantities[i] =
            meanOfKnown(start, [&](const EpisodeResult& episode) { return episode.rollouts[rollout].quantities[i]; });
      }
    }
  }
  return means;
}

std::vector<PairTable> pairsByStart(const Protocol& protocol, const std::vector<EpisodeResult>& first,
                                    std::size_t rollout_in_first, const std::vector<EpisodeResult>& second,
                                    std::size_t rollout_in_second) {
  std::vector<PairTable> tables;
  int last = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const int start = first[i].index / protocol.repeats;
    if (tables.empty() || start != last) {
      tables.emplace_back();
    }
    tables.back().add(first[i].rollouts[rollout_in_first].success, second[i].rollouts[rollout_in_second].success);
    last = start;
  }
  return tables;
}

std::vector<StartCount> successesByStart(const Protocol& protocol, const std::vector<EpisodeResult>& episodes,
                                         std::size_t rollout) {
  std::vector<StartCount> counts;
  for (const PairTable& table : pairsByStart(protocol, episodes, rollout, episodes, rollout)) {
    counts.push_back({table.both, table.pairs()});
  }
  return counts;
}

}  // namespace sim2sim
