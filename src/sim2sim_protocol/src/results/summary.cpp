// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace sim2sim {
namespace {

constexpr double kNoRatio = std::numeric_limits<double>::quiet_NaN();

/// Index of the floor with the largest shift of the initial state, if the protocol has one.
std::optional<std::size_t> widestFloor(const Protocol& protocol) {
  const std::vector<std::string> names = protocol.rolloutNames();
  const auto floor = std::find(names.begin(), names.end(), floorProbes().back().name);
  return floor == names.end() ? std::nullopt : std::optional(static_cast<std::size_t>(floor - names.begin()));
}

/// Episodes in which the reference does exactly the same from the initial state that is moved least: it cannot tell the
/// two apart.
int unmovedFloors(const Protocol& protocol, const std::vector<EpisodeResult>& episodes) {
  const std::vector<std::string> names = protocol.rolloutNames();
  const auto floor = std::find(names.begin(), names.end(), floorProbes().front().name);
  if (floor == names.end()) {
    return 0;
  }
  const auto rollout = static_cast<std::size_t>(floor - names.begin());
  return static_cast<int>(std::count_if(episodes.begin(), episodes.end(), [rollout](const EpisodeResult& episode) {
    const RolloutResult& result = episode.rollouts[rollout];
    return result.at("mean_position_divergence") == 0.0 && result.at("mean_angle_divergence") == 0.0;
  }));
}

SuccessRate successRate(const std::vector<EpisodeResult>& episodes, Mode mode) {
  const auto successes =
      static_cast<int>(std::count_if(episodes.begin(), episodes.end(),
                                     [mode](const EpisodeResult& episode) { return episode.rollouts[mode].success; }));
  const auto trials = static_cast<int>(episodes.size());
  return {successes, static_cast<double>(successes) / trials, wilsonInterval(successes, trials)};
}

Outcomes outcomesOf(const std::vector<EpisodeResult>& episodes) {
  const PairTable table = pairsOf(episodes, kReferenceClosed, episodes, kEngineClosed);
  Outcomes outcomes;
  outcomes.table = table;
  outcomes.difference_interval = tangoInterval(table);
  outcomes.p = mcnemarMidP(table);
  outcomes.p_exact = mcnemarExact(table);
  const int reference = table.both + table.first_only;
  if (reference > 0) {
    outcomes.transfer = (table.both + table.second_only) / static_cast<double>(reference);
    outcomes.transfer_interval = tangInterval(table);
  }
  return outcomes;
}

double ratio(double a, double b) { return b > 0.0 ? a / b : kNoRatio; }

/// `floor` is the place of the floor's rollout, if there is one.
BaselineComparison comparisonOf(const std::vector<EpisodeResult>& episodes, const Summary& summary, std::size_t rollout,
                                const DivergencePair& pair, std::optional<std::size_t> floor) {
  const std::size_t divergence = quantityIndex(pair.divergence);
  const std::size_t null_model = quantityIndex(pair.null_model);
  const double mean = summary.means[rollout][divergence].value;
  return {medianOf(samplesOf(episodes, rollout, divergence)),
          meanDifference(differencesOf(episodes, {rollout, divergence}, episodes, {rollout, null_model})),
          ratio(mean, summary.means[rollout][null_model].value),
          floor ? ratio(mean, summary.means[*floor][divergence].value) : kNoRatio};
}

}  // namespace

std::vector<double> differencesOf(const std::vector<EpisodeResult>& more, const FigureIndex& of_more,
                                  const std::vector<EpisodeResult>& less, const FigureIndex& of_less) {
  std::vector<double> differences;
  differences.reserve(more.size());
  for (std::size_t i = 0; i < more.size(); ++i) {
    const double difference = more[i].rollouts[of_more.rollout].quantities[of_more.quantity] -
                              less[i].rollouts[of_less.rollout].quantities[of_less.quantity];
    if (!std::isnan(difference)) {
      differences.push_back(difference);
    }
  }
  return differences;
}

PairTable pairsOf(const std::vector<EpisodeResult>& first, std::size_t rollout_in_first,
                  const std::vector<EpisodeResult>& second, std::size_t rollout_in_second) {
  PairTable table;
  for (std::size_t i = 0; i < first.size(); ++i) {
    table.add(first[i].rollouts[rollout_in_first].success, second[i].rollouts[rollout_in_second].success);
  }
  return table;
}

std::optional<bool> BaselineComparison::beatsNull() const {
  return minus_null.interval ? std::optional(minus_null.interval->high < 0.0) : std::nullopt;
}

std::vector<double> samplesOf(const std::vector<EpisodeResult>& episodes, std::size_t rollout, std::size_t quantity) {
  std::vector<double> samples;
  samples.reserve(episodes.size());
  for (const EpisodeResult& episode : episodes) {
    if (const double sample = episode.rollouts[rollout].quantities[quantity]; !std::isnan(sample)) {
      samples.push_back(sample);
    }
  }
  return samples;
}

Estimate meanOf(const std::vector<double>& samples, const Quantity& quantity) {
  if (samples.empty()) {
    return {};
  }
  if (quantity.least == 0.0) {
    return meanOf(samples, quantity.limit);
  }
  Difference mean = meanDifference(samples);
  if (mean.interval) {  // Student's t knows no range
    mean.interval->low = std::max(mean.interval->low, quantity.least);
    mean.interval->high = std::min(mean.interval->high, quantity.limit);
  }
  return {mean.value, mean.interval};
}

Summary summarize(const Protocol& protocol, const std::vector<EpisodeResult>& episodes) {
  Summary summary;
  summary.episodes = static_cast<int>(episodes.size());
  summary.reference = successRate(episodes, kReferenceClosed);
  summary.engine = successRate(episodes, kEngineClosed);
  summary.outcomes = outcomesOf(episodes);
  summary.means.resize(episodes.front().rollouts.size());
  for (std::size_t rollout = 0; rollout < summary.means.size(); ++rollout) {
    for (std::size_t i = 0; i < kQuantities.size(); ++i) {
      const std::vector<double> samples = samplesOf(episodes, rollout, i);
      summary.means[rollout][i] = meanOf(samples, kQuantities[i]);
    }
  }
  summary.baselines.resize(summary.means.size());
  const std::optional<std::size_t> floor = widestFloor(protocol);
  for (std::size_t rollout = kReferenceClosed + 1; rollout < summary.means.size(); ++rollout) {
    for (std::size_t i = 0; i < kDivergencePairs.size(); ++i) {
      summary.baselines[rollout][i] = comparisonOf(episodes, summary, rollout, kDivergencePairs[i], floor);
    }
  }
  summary.first_divergences = firstDivergencesOf(episodes, kEngineReplay);
  if (floor) {
    summary.floor = firstDivergencesOf(episodes, *floor);
    summary.unmoved_floors = unmovedFloors(protocol, episodes);
  }
  return summary;
}

}  // namespace sim2sim
