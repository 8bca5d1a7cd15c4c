// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/partings.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pusht_task/numbers.hpp"

namespace sim2sim {
namespace {

using nlohmann::json;

json shareOf(int count, int total) {
  json share = {{"episodes", count}};
  if (total > 0) {
    const Interval interval = wilsonInterval(count, total);
    share["share"] = pusht::roundToMicro(static_cast<double>(count) / total);
    share["interval"] = {pusht::roundToMicro(interval.low), pusht::roundToMicro(interval.high)};
  }
  return share;
}

}  // namespace

Partings partingsOf(const std::vector<EpisodeResult>& episodes, std::size_t rollout) {
  Partings partings;
  partings.episodes = static_cast<int>(episodes.size());
  std::vector<int> parted;  // by step
  std::vector<int> ended;   // within the bound, by step
  for (const EpisodeResult& episode : episodes) {
    const std::optional<Parting>& parting = episode.rollouts[rollout].parting;
    // Both must go on for the two to be compared.
    const int common = std::min(episode.rollouts[rollout].steps, episode.rollouts[kReferenceClosed].steps);
    const auto last = static_cast<std::size_t>(parting ? parting->step : common);
    parted.resize(std::max(parted.size(), last + 1));
    ended.resize(parted.size());
    if (parting) {
      ++partings.parted;
      ++partings.causes[static_cast<std::size_t>(parting->cause)];
      ++partings.first[static_cast<std::size_t>(parting->first)];
      ++parted[last];
    } else {
      ++ended[last];
    }
  }
  int there = partings.episodes;
  double within = 1.0;
  for (std::size_t step = 0; step < parted.size(); ++step) {
    within *= 1.0 - static_cast<double>(parted[step]) / there;
    partings.within.push_back(within);
    if (within <= 0.5 && !partings.median_step) {
      partings.median_step = static_cast<int>(step);
    }
    there -= parted[step] + ended[step];
  }
  return partings;
}

json toJson(const Partings& partings) {
  json result = {{"parted", shareOf(partings.parted, partings.episodes)},
                 {"median_step", partings.median_step ? json(*partings.median_step) : json()},
                 {"causes", json::object()},
                 {"first", json::object()},
                 {"within_by_step", json::array()}};
  for (const CauseName& cause : kCauses) {
    result["causes"][cause.name] = shareOf(partings.causes[static_cast<std::size_t>(cause.cause)], partings.parted);
  }
  for (std::size_t i = 0; i < kFirstNames.size(); ++i) {
    result["first"][kFirstNames[i]] = shareOf(partings.first[i], partings.parted);
  }
  for (const double share : partings.within) {
    result["within_by_step"].push_back(pusht::roundToMicro(share));
  }
  return result;
}

const CauseName& mostFrequentCause(const Partings& partings) {
  const auto most = std::max_element(partings.causes.begin(), partings.causes.end());
  return kCauses[static_cast<std::size_t>(most - partings.causes.begin())];
}

}  // namespace sim2sim
