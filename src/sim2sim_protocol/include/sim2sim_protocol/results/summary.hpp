// SPDX-License-Identifier: BSD-3-Clause
/// What the finished episodes of a run say, each figure with what is needed to read it.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/first_divergences.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"

namespace sim2sim {

struct SuccessRate {
  int successes;
  double rate;
  Interval interval;
};

/// Where a figure stands in the results of an episode.
struct FigureIndex {
  std::size_t rollout;
  std::size_t quantity;
};

/// What one figure is more than the other, episode by episode, of those that have both. The two may be of one run, or
/// of two runs over the same episodes.
std::vector<double> differencesOf(const std::vector<EpisodeResult>& more, const FigureIndex& of_more,
                                  const std::vector<EpisodeResult>& less, const FigureIndex& of_less);

/// Who succeeds in which episodes, likewise.
PairTable pairsOf(const std::vector<EpisodeResult>& first, std::size_t rollout_in_first,
                  const std::vector<EpisodeResult>& second, std::size_t rollout_in_second);

/// How the engine's successes stand to the reference's, over the same episodes.
struct Outcomes {
  PairTable table;                              ///< first: the reference
  std::optional<Interval> difference_interval;  ///< Tango's
  double p;                                     ///< McNemar's test, mid-p: are the rates equal?
  double p_exact;
  std::optional<double> transfer;             ///< engine over reference success; none if the reference never succeeds
  std::optional<Interval> transfer_interval;  ///< Tang's
};

/// A divergence, and that of a tee that never moves, over the same steps.
struct DivergencePair {
  const char* divergence;  ///< names in kQuantities
  const char* null_model;
};

inline constexpr std::array kDivergencePairs = {
    DivergencePair{"mean_position_divergence", "null_position_divergence"},
    DivergencePair{"mean_angle_divergence", "null_angle_divergence"},
};

/// What a mean divergence must be read against. NaN where there is none.
struct BaselineComparison {
  Estimate median{};
  Difference minus_null{};                                          ///< divergence - null model, episode by episode
  double share_of_null = std::numeric_limits<double>::quiet_NaN();  ///< of the means
  double over_floor = std::numeric_limits<double>::quiet_NaN();     ///< multiples of the mean of the widest floor

  /// Whether it is surely less than that of a tee that never moves. Without an interval nobody knows.
  std::optional<bool> beatsNull() const;
};

struct Summary {
  using Means = std::array<Estimate, kQuantities.size()>;
  using Baselines = std::array<BaselineComparison, kDivergencePairs.size()>;

  int episodes = 0;
  SuccessRate reference{};
  SuccessRate engine{};
  Outcomes outcomes{};
  std::vector<Means> means;              ///< over the episodes that have the quantity, by rollout; NaN where none has
  std::vector<Baselines> baselines;      ///< by rollout; none for the reference
  FirstDivergences first_divergences{};  ///< of the replay
  std::optional<FirstDivergences> floor{};  ///< of the widest floor, if there is one: when the reference leaves itself
  int unmoved_floors = 0;                   ///< episodes whose narrowest floor is exactly the reference

  const Estimate& mean(std::size_t rollout, std::string_view quantity) const {
    return means.at(rollout)[quantityIndex(quantity)];
  }
};

/// Of at least one episode of the protocol, in index order.
Summary summarize(const Protocol& protocol, const std::vector<EpisodeResult>& episodes);

/// With the interval that fits the quantity's range; NaN without samples.
Estimate meanOf(const std::vector<double>& samples, const Quantity& quantity);

/// Of a quantity in one rollout, over the episodes that have it.
std::vector<double> samplesOf(const std::vector<EpisodeResult>& episodes, std::size_t rollout, std::size_t quantity);

}  // namespace sim2sim
