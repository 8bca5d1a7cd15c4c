// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/tails.hpp"
#include "starts.hpp"

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

SuccessRate successRate(const Protocol& protocol, const std::vector<EpisodeResult>& episodes, std::size_t rollout) {
  const auto successes =
      static_cast<int>(std::count_if(episodes.begin(), episodes.end(), [rollout](const EpisodeResult& episode) {
        return episode.rollouts[rollout].success;
      }));
  const auto trials = static_cast<int>(episodes.size());
  SuccessRate rate{successes, static_cast<double>(successes) / trials, std::nullopt};
  if (!protocol.until_decided) {
    rate.interval = protocol.repeats == 1 ? wilsonInterval(successes, trials)
                                          : repeatedRateInterval(successesByStart(protocol, episodes, rollout));
  }
  return rate;
}

/// Rollouts of the model variants: the replays, or the closed loops.
std::vector<std::size_t> variantRollouts(const Protocol& protocol, bool closed) {
  std::vector<std::size_t> rollouts;
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (probes[i].world == ProbedWorld::kVariant && probes[i].closed == closed) {
      rollouts.push_back(rolloutOfProbe(i));
    }
  }
  return rollouts;
}

std::vector<ClosedVariant> closedVariants(const Protocol& protocol, const std::vector<EpisodeResult>& episodes) {
  std::vector<ClosedVariant> variants;
  std::vector<double> p;
  for (const std::size_t rollout : variantRollouts(protocol, true)) {
    variants.push_back({rollout, successRate(protocol, episodes, rollout), outcomesOf(protocol, episodes, rollout)});
    if (variants.back().outcomes.p) {
      p.push_back(*variants.back().outcomes.p);
    }
  }
  const std::vector<double> adjusted = holm(p);
  for (std::size_t i = 0; i < adjusted.size(); ++i) {  // all have a p, or none has: the starts are the same
    variants[i].adjusted_p = adjusted[i];
  }
  return variants;
}

double ratio(double a, double b) { return b > 0.0 ? a / b : kNoRatio; }

/// Ratio of the means of two rollouts, with its interval.
struct Multiple {
  double value = kNoRatio;
  std::optional<Interval> interval{};
};

/// Values of a quantity in several rollouts, of the episodes that have all of them.
std::vector<std::vector<double>> commonSamples(const std::vector<EpisodeResult>& episodes,
                                               const std::vector<std::size_t>& rollouts, std::size_t quantity) {
  std::vector<std::vector<double>> samples(rollouts.size());
  for (const EpisodeResult& episode : episodes) {
    const auto value = [&](std::size_t rollout) { return episode.rollouts[rollout].quantities[quantity]; };
    if (std::none_of(rollouts.begin(), rollouts.end(),
                     [&](std::size_t rollout) { return std::isnan(value(rollout)); })) {
      for (std::size_t i = 0; i < rollouts.size(); ++i) {
        samples[i].push_back(value(rollouts[i]));
      }
    }
  }
  return samples;
}

/// Multiple of the largest of several baselines; of none if there are none.
Multiple multipleOf(const Protocol& protocol, const std::vector<EpisodeResult>& episodes, const FigureIndex& figure,
                    const std::vector<std::size_t>& baselines) {
  std::vector<std::size_t> rollouts = baselines;
  rollouts.push_back(figure.rollout);
  std::vector<std::vector<double>> samples = commonSamples(episodes, rollouts, figure.quantity);
  const std::vector<double> numerators = std::move(samples.back());
  samples.pop_back();
  Multiple multiple;
  std::optional<double> extreme = extremeOf(episodes, figure);
  for (std::size_t i = 0; i < baselines.size(); ++i) {
    multiple.value = std::fmin(multiple.value, ratio(averageOf(numerators), averageOf(samples[i])));
    extreme = std::max(extreme, extremeOf(episodes, {baselines[i], figure.quantity}));
  }
  const bool is_a_baseline = std::find(baselines.begin(), baselines.end(), figure.rollout) != baselines.end();
  if (!protocol.until_decided && !baselines.empty() && !is_a_baseline && extreme) {
    multiple.interval = tailRatioToLargest(numerators, samples, *extreme);
  }
  return multiple;
}

/// `floor` is the rollout of the floor, if there is one; `variants` are those of the model variants' replays.
BaselineComparison comparisonOf(const Protocol& protocol, const std::vector<EpisodeResult>& episodes,
                                std::size_t rollout, const DivergencePair& pair, std::optional<std::size_t> floor,
                                const std::vector<std::size_t>& variants) {
  const FigureIndex figure{rollout, quantityIndex(pair.divergence)};
  const FigureIndex null_model{rollout, quantityIndex(pair.null_model)};
  const std::vector<double> samples = samplesOf(episodes, figure);
  BaselineComparison comparison;
  comparison.starts = static_cast<int>(samples.size());
  comparison.episodes = comparison.starts;
  comparison.median = medianOf(protocol, samples);
  const std::vector<double> differences = differencesOf(episodes, figure, episodes, null_model);
  comparison.minus_null = protocol.until_decided ? Difference{averageOf(differences), {}, {}}
                                                 : pairedDifference(differences, extremeOf(episodes, figure));
  comparison.share_of_null = ratio(averageOf(samples), averageOf(samplesOf(episodes, null_model)));
  comparison.share_of_largest = shareOfLargest(samples);
  if (floor) {
    const Multiple multiple = multipleOf(protocol, episodes, figure, {*floor});
    comparison.over_floor = multiple.value;
    comparison.over_floor_interval = multiple.interval;
  }
  const Multiple multiple = multipleOf(protocol, episodes, figure, variants);
  comparison.over_variants = multiple.value;
  comparison.over_variants_interval = multiple.interval;
  return comparison;
}

/// Values of a figure by start.
std::vector<std::vector<double>> valuesByStart(const Protocol& protocol, const std::vector<EpisodeResult>& episodes,
                                               const FigureIndex& figure) {
  std::vector<std::vector<double>> values;
  for (const std::vector<const EpisodeResult*>& start : byStart(protocol, episodes)) {
    values.emplace_back();
    for (const EpisodeResult* episode : start) {
      if (const double value = episode->rollouts[figure.rollout].quantities[figure.quantity]; !std::isnan(value)) {
        values.back().push_back(value);
      }
    }
  }
  return values;
}

NoiseSplits noiseSplits(const Protocol& protocol, const std::vector<EpisodeResult>& episodes) {
  NoiseSplits splits{successNoiseSplit(successesByStart(protocol, episodes, kReferenceClosed)), {}, {}};
  if (protocol.alone) {
    return splits;
  }
  splits.engine = successNoiseSplit(successesByStart(protocol, episodes, kEngineClosed));
  for (std::size_t i = 0; i < kWholeEpisodePairs; ++i) {
    const FigureIndex figure{kEngineReplay, quantityIndex(kDivergencePairs[i].divergence)};
    splits.divergences[i] = noiseSplit(valuesByStart(protocol, episodes, figure));
  }
  return splits;
}

/// Counts of the pairs, without intervals and tests.
Outcomes countedOutcomes(const PairTable& table) {
  Outcomes outcomes;
  outcomes.table = table;
  outcomes.starts = table.pairs();
  if (const int reference = table.both + table.first_only; reference > 0) {
    outcomes.transfer = (table.both + table.second_only) / static_cast<double>(reference);
  }
  return outcomes;
}

}  // namespace

Outcomes outcomesOf(const PairTable& table) {
  Outcomes outcomes = countedOutcomes(table);
  outcomes.difference_interval = tangoInterval(table);
  outcomes.p = mcnemarMidP(table);
  outcomes.p_exact = mcnemarExact(table);
  if (outcomes.transfer) {
    outcomes.transfer_interval = tangInterval(table);
  }
  return outcomes;
}

Outcomes outcomesOf(const Protocol& protocol, const std::vector<EpisodeResult>& episodes, std::size_t rollout) {
  const PairTable table = pairsOf(episodes, kReferenceClosed, episodes, rollout);
  if (protocol.until_decided) {
    return countedOutcomes(table);
  }
  if (protocol.repeats == 1) {
    return outcomesOf(table);
  }
  const std::vector<PairTable> starts = pairsByStart(protocol, episodes, kReferenceClosed, episodes, rollout);
  const Difference difference = repeatedDifference(starts);
  Outcomes outcomes = countedOutcomes(table);
  outcomes.starts = static_cast<int>(starts.size());
  outcomes.difference_interval = difference.interval;
  outcomes.p = difference.p;
  outcomes.transfer_interval = repeatedRatioInterval(starts);
  return outcomes;
}

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

bool BaselineComparison::isMostlyOfLargest() const {
  constexpr double kMost = 0.5;
  return starts >= kFewestOfTail && share_of_largest > kMost;
}

std::vector<double> samplesOf(const std::vector<EpisodeResult>& episodes, const FigureIndex& figure) {
  std::vector<double> samples;
  samples.reserve(episodes.size());
  for (const EpisodeResult& episode : episodes) {
    if (const double sample = episode.rollouts[figure.rollout].quantities[figure.quantity]; !std::isnan(sample)) {
      samples.push_back(sample);
    }
  }
  return samples;
}

std::optional<double> extremeOf(const std::vector<EpisodeResult>& episodes, const FigureIndex& figure) {
  const Quantity& quantity = kQuantities[figure.quantity];
  if (quantity.scope == Scope::kPushes) {
    return quantity.limit - quantity.least;
  }
  if (quantity.null_model == nullptr || !quantity.hasIntervals()) {
    return std::nullopt;
  }
  const std::vector<double> samples = samplesOf(episodes, {figure.rollout, quantityIndex(quantity.null_model)});
  return samples.empty() ? std::nullopt : std::optional(averageOf(samples));
}

Estimate meanOf(const std::vector<double>& samples, const Quantity& quantity, const std::optional<double>& extreme) {
  if (samples.empty()) {
    return {};
  }
  if (quantity.least == 0.0) {
    Estimate mean = meanOf(samples, quantity.limit);
    if (quantity.null_model != nullptr || extreme) {
      mean.interval = extreme ? tailMeanInterval(samples, *extreme) : std::nullopt;
    }
    return mean;
  }
  Difference mean = pairedDifference(samples, extreme);
  if (mean.interval) {  // the method knows no range
    mean.interval->low = std::max(mean.interval->low, quantity.least);
    mean.interval->high = std::min(mean.interval->high, quantity.limit);
  }
  return {mean.value, mean.interval};
}

Estimate meanOf(const Protocol& protocol, const std::vector<EpisodeResult>& episodes, const FigureIndex& figure) {
  const std::vector<double> samples = samplesOf(episodes, figure);
  return protocol.until_decided ? Estimate{averageOf(samples), std::nullopt}
                                : meanOf(samples, kQuantities[figure.quantity], extremeOf(episodes, figure));
}

Estimate medianOf(const Protocol& protocol, std::vector<double> samples) {
  if (!protocol.until_decided || samples.empty()) {
    return medianOf(std::move(samples));
  }
  std::sort(samples.begin(), samples.end());
  return {quantileOf(samples, 0.5), std::nullopt};
}

Summary summarize(const Protocol& protocol, const std::vector<EpisodeResult>& episodes) {
  Summary summary;
  summary.episodes = static_cast<int>(episodes.size());
  summary.reference = successRate(protocol, episodes, kReferenceClosed);
  summary.engine = successRate(protocol, episodes, kEngineClosed);
  summary.outcomes = outcomesOf(protocol, episodes, kEngineClosed);
  summary.endings = endingsOf(episodes);
  summary.means.resize(episodes.front().rollouts.size());
  const std::vector<EpisodeResult> starts = meansOfStarts(protocol, episodes);
  for (std::size_t rollout = 0; rollout < summary.means.size(); ++rollout) {
    for (std::size_t i = 0; i < kQuantities.size(); ++i) {
      summary.means[rollout][i] = meanOf(protocol, starts, {rollout, i});
    }
  }
  summary.baselines.resize(summary.means.size());
  const std::optional<std::size_t> floor = widestFloor(protocol);
  const std::vector<std::size_t> variants = variantRollouts(protocol, false);
  for (std::size_t rollout = kReferenceClosed + 1; rollout < summary.means.size(); ++rollout) {
    if (!protocol.isFlown(rollout)) {
      continue;
    }
    for (std::size_t i = 0; i < kDivergencePairs.size(); ++i) {
      summary.baselines[rollout][i] = comparisonOf(protocol, starts, rollout, kDivergencePairs[i], floor, variants);
      const FigureIndex figure{rollout, quantityIndex(kDivergencePairs[i].divergence)};
      summary.baselines[rollout][i].episodes = static_cast<int>(samplesOf(episodes, figure).size());
    }
  }
  summary.closed_variants = closedVariants(protocol, episodes);
  summary.first_divergences = firstDivergencesOf(episodes, kEngineReplay);
  if (floor) {
    summary.floor = firstDivergencesOf(episodes, *floor);
    summary.unmoved_floors = unmovedFloors(protocol, episodes);
  }
  if (protocol.repeats > 1) {
    summary.noise = noiseSplits(protocol, episodes);
  }
  return summary;
}

}  // namespace sim2sim
