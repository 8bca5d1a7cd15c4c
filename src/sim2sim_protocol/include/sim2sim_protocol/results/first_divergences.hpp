// SPDX-License-Identifier: BSD-3-Clause
/// When and how the rollouts of a run part from the reference, over its episodes.
#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// Of one rollout, over at least one episode.
struct FirstDivergences {
  int episodes = 0;
  int parted = 0;                                   ///< episodes in which it leaves the bound
  std::array<int, kCauses.size()> causes{};         ///< of those
  std::array<int, kFirstBodyNames.size()> first{};  ///< who was the first to be elsewhere
  std::vector<double> within;                       ///< by control step: the share still within the bound
  std::optional<int> median_step;                   ///< the first at which that is at most a half
};

/// An episode that ends within the bound says no more about later steps: the share still within is the product, over
/// the steps, of those that stay among those that are still there.
/// Source: E. L. Kaplan and P. Meier, "Nonparametric Estimation from Incomplete Observations" (1958).
FirstDivergences firstDivergencesOf(const std::vector<EpisodeResult>& episodes, std::size_t rollout);

/// With shares, and Wilson's intervals of them.
nlohmann::json toJson(const FirstDivergences& first_divergences);

/// The cause that most of the first_divergences have; there must be one.
const CauseName& mostFrequentCause(const FirstDivergences& first_divergences);

}  // namespace sim2sim
