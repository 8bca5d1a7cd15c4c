// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/first_divergences.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/json.hpp"

namespace sim2sim {
using nlohmann::json;

FirstDivergences firstDivergencesOf(const std::vector<EpisodeResult>& episodes, std::size_t rollout) {
  FirstDivergences first_divergences;
  first_divergences.episodes = static_cast<int>(episodes.size());
  std::vector<int> parted;  // by step
  std::vector<int> ended;   // within the bound, by step
  for (const EpisodeResult& episode : episodes) {
    const std::optional<FirstDivergence>& first_divergence = episode.rollouts[rollout].first_divergence;
    // Both must go on for the two to be compared.
    const int common = std::min(episode.rollouts[rollout].steps, episode.rollouts[kReferenceClosed].steps);
    const auto last = static_cast<std::size_t>(first_divergence ? first_divergence->step : common);
    parted.resize(std::max(parted.size(), last + 1));
    ended.resize(parted.size());
    if (first_divergence) {
      ++first_divergences.parted;
      ++first_divergences.causes[static_cast<std::size_t>(first_divergence->cause)];
      ++first_divergences.first[static_cast<std::size_t>(first_divergence->first)];
      ++parted[last];
    } else {
      ++ended[last];
    }
  }
  int there = first_divergences.episodes;
  double within = 1.0;
  for (std::size_t step = 0; step < parted.size(); ++step) {
    within *= 1.0 - static_cast<double>(parted[step]) / there;
    first_divergences.within.push_back(within);
    if (within <= 0.5 && !first_divergences.median_step) {
      first_divergences.median_step = static_cast<int>(step);
    }
    there -= parted[step] + ended[step];
  }
  return first_divergences;
}

json toJson(const FirstDivergences& first_divergences, bool has_intervals) {
  json result = {{"parted", shareJson(first_divergences.parted, first_divergences.episodes, has_intervals)},
                 {"median_step", orNull(first_divergences.median_step)},
                 {"causes", json::object()},
                 {"first", json::object()},
                 {"within_by_step", json::array()}};
  for (const CauseName& cause : kCauses) {
    result["causes"][cause.name] = shareJson(first_divergences.causes[static_cast<std::size_t>(cause.cause)],
                                             first_divergences.parted, has_intervals);
  }
  for (std::size_t i = 0; i < kFirstBodyNames.size(); ++i) {
    result["first"][kFirstBodyNames[i]] =
        shareJson(first_divergences.first[i], first_divergences.parted, has_intervals);
  }
  for (const double share : first_divergences.within) {
    result["within_by_step"].push_back(pusht::roundToMicro(share));
  }
  return result;
}

const CauseName& mostFrequentCause(const FirstDivergences& first_divergences) {
  const auto most = std::max_element(first_divergences.causes.begin(), first_divergences.causes.end());
  return kCauses[static_cast<std::size_t>(most - first_divergences.causes.begin())];
}

}  // namespace sim2sim
