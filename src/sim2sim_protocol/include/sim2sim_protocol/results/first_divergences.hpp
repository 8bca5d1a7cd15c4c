// SPDX-License-Identifier: BSD-3-Clause
/// First divergences of a rollout over the episodes of a run: how many, when, and by which cause.
#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// First divergences of one rollout over at least one episode.
struct FirstDivergences {
  int episodes = 0;
  int parted = 0;                                   ///< episodes in which the rollout leaves the bound
  std::array<int, kCauses.size()> causes{};         ///< episodes by cause
  std::array<int, kFirstBodyNames.size()> first{};  ///< episodes by the body that differs first
  std::vector<double> within;                       ///< [-] share of episodes still within the bound, by control step
  std::optional<int> median_step;  ///< first control step at which `within` is at most a half; empty: never
};

/// Counts first divergences. An episode that ends within the bound is censored there: `within` is the Kaplan-Meier
/// estimate, the product over the steps of the share of those still running that stay within.
/// Source: E. L. Kaplan and P. Meier, "Nonparametric Estimation from Incomplete Observations" (1958).
FirstDivergences firstDivergencesOf(const std::vector<EpisodeResult>& episodes, std::size_t rollout);

/// "parting" in statistics.json: counts, and shares as shareJson().
nlohmann::json toJson(const FirstDivergences& first_divergences, bool has_intervals);

/// Most frequent cause; there must be one.
const CauseName& mostFrequentCause(const FirstDivergences& first_divergences);

}  // namespace sim2sim
