// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/statistics.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/endings.hpp"
#include "sim2sim_protocol/results/first_divergences.hpp"
#include "sim2sim_protocol/results/headline.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "starts.hpp"

namespace sim2sim {
namespace {

using nlohmann::json;

constexpr std::array kShownQuantiles = {0.05, 0.25, 0.75, 0.95};

/// Distribution of a figure.
json distribution(const Protocol& protocol, const std::vector<EpisodeResult>& starts,
                  const std::vector<EpisodeResult>& episodes, const FigureIndex& figure) {
  std::vector<double> samples = samplesOf(starts, figure);
  json figures = {{"episodes", samplesOf(episodes, figure).size()}};
  if (samples.empty()) {
    return figures;
  }
  const Estimate mean = meanOf(protocol, starts, figure);
  std::sort(samples.begin(), samples.end());
  const Estimate median = medianOf(protocol, samples);
  addFigure(figures, "mean", "", mean.value, mean.interval);
  figures["standard_deviation"] = samples.size() < 2 ? json() : readableJson(standardDeviation(samples));
  addFigure(figures, "median", "", median.value, median.interval);
  for (const double probability : kShownQuantiles) {
    figures["quantiles"][pusht::shortestText(probability)] = readableJson(quantileOf(samples, probability));
  }
  return figures;
}

}  // namespace

nlohmann::json statistics(const RunConfiguration& configuration, const std::vector<EpisodeResult>& episodes) {
  const Protocol& protocol = configuration.protocol;
  const Outcomes outcomes = outcomesOf(protocol, episodes, kEngineClosed);
  const std::vector<EpisodeResult> starts = meansOfStarts(protocol, episodes);
  json statistics = {{"format", kStatisticsFormat},
                     {"confidence", kConfidence},
                     {"episodes", episodes.size()},
                     {"headline", toJson(headlineOf(configuration, outcomes, endingsOf(episodes)))}};
  const std::vector<std::string> rollouts = protocol.rolloutNames();
  const bool shares_have_intervals = protocol.repeats == 1 && !protocol.until_decided;
  forEachQuantity(protocol, [&](std::size_t rollout, std::size_t i) {
    const std::string name = std::string(kQuantities[i].name) + "_" + kQuantities[i].unit;
    statistics["rollouts"][rollouts[rollout]][name] = distribution(protocol, starts, episodes, {rollout, i});
  });
  for (std::size_t rollout = kReferenceClosed + 1; rollout < rollouts.size(); ++rollout) {
    if (protocol.isFlown(rollout)) {
      statistics["rollouts"][rollouts[rollout]]["parting"] =
          toJson(firstDivergencesOf(episodes, rollout), shares_have_intervals);
    }
  }
  for (std::size_t rollout = 0; rollout < rollouts.size(); ++rollout) {
    if (protocol.isClosed(rollout)) {
      statistics["rollouts"][rollouts[rollout]]["ending"] = toJson(endingsOf(episodes, rollout), shares_have_intervals);
    }
  }
  if (protocol.repeats > 1) {
    statistics["number_of_starts"] = outcomes.starts;
  }
  return statistics;
}

}  // namespace sim2sim
