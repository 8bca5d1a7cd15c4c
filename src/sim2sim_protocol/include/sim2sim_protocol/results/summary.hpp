// SPDX-License-Identifier: BSD-3-Clause
/// Summary of the finished episodes of a run: each figure with its interval and its baselines.
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

/// Success rate in closed loop, with Wilson's interval.
struct SuccessRate {
  int successes;
  double rate;
  Interval interval;
};

/// Index of a figure in the results of an episode.
struct FigureIndex {
  std::size_t rollout;   ///< in EpisodeResult::rollouts
  std::size_t quantity;  ///< in kQuantities
};

/// Paired differences of two figures, more - less, of the episodes that have both. The two may be of one run, or of two
/// runs over the same episodes.
std::vector<double> differencesOf(const std::vector<EpisodeResult>& more, const FigureIndex& of_more,
                                  const std::vector<EpisodeResult>& less, const FigureIndex& of_less);

/// Paired successes of two rollouts, of one run or of two runs over the same episodes.
PairTable pairsOf(const std::vector<EpisodeResult>& first, std::size_t rollout_in_first,
                  const std::vector<EpisodeResult>& second, std::size_t rollout_in_second);

/// Successes of engine and reference over the same episodes.
struct Outcomes {
  PairTable table;                              ///< first: the reference
  std::optional<Interval> difference_interval;  ///< Tango's
  double p;                                     ///< McNemar's test, mid-p: are the rates equal?
  double p_exact;
  std::optional<double> transfer;             ///< engine over reference success; none if the reference never succeeds
  std::optional<Interval> transfer_interval;  ///< Tang's
};

/// A divergence and its null model over the same steps: a tee that never moves.
struct DivergencePair {
  const char* divergence;  ///< names in kQuantities
  const char* null_model;
};

inline constexpr std::array kDivergencePairs = {
    DivergencePair{"mean_position_divergence", "null_position_divergence"},
    DivergencePair{"mean_angle_divergence", "null_angle_divergence"},
};

/// Comparison of a mean divergence with its baselines, the null model and the floor. NaN if there is none.
struct BaselineComparison {
  Estimate median{};
  Difference minus_null{};                                          ///< divergence - null model, episode by episode
  double share_of_null = std::numeric_limits<double>::quiet_NaN();  ///< ratio of the means
  double over_floor = std::numeric_limits<double>::quiet_NaN();     ///< multiples of the mean of the widest floor

  /// Whether the divergence is shown to be less than the null model's; empty without an interval.
  std::optional<bool> beatsNull() const;
};

/// Figures of a run.
struct Summary {
  using Means = std::array<Estimate, kQuantities.size()>;
  using Baselines = std::array<BaselineComparison, kDivergencePairs.size()>;

  int episodes = 0;
  SuccessRate reference{};
  SuccessRate engine{};
  Outcomes outcomes{};
  std::vector<Means> means;              ///< by rollout, over the episodes that have the quantity; NaN if none has
  std::vector<Baselines> baselines;      ///< by rollout; NaN for the reference
  FirstDivergences first_divergences{};  ///< those of the replay in open loop
  std::optional<FirstDivergences>
      floor{};             ///< those of the widest floor, of the reference from itself; empty without floors
  int unmoved_floors = 0;  ///< episodes whose narrowest floor has divergence 0

  const Estimate& mean(std::size_t rollout, std::string_view quantity) const {
    return means.at(rollout)[quantityIndex(quantity)];
  }
};

/// Summarizes at least one episode of the protocol, in index order.
Summary summarize(const Protocol& protocol, const std::vector<EpisodeResult>& episodes);

/// Mean of a quantity, with the interval that fits its range; NaN without samples.
Estimate meanOf(const std::vector<double>& samples, const Quantity& quantity);

/// Values of a quantity in one rollout, of the episodes that have it.
std::vector<double> samplesOf(const std::vector<EpisodeResult>& episodes, std::size_t rollout, std::size_t quantity);

}  // namespace sim2sim
