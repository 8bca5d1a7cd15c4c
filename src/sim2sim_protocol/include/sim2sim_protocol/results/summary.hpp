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
#include "sim2sim_protocol/results/endings.hpp"
#include "sim2sim_protocol/results/first_divergences.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"
#include "sim2sim_statistics/repeats.hpp"

namespace sim2sim {

/// Success rate in closed loop, with Wilson's interval; with repeats repeatedRateInterval().
struct SuccessRate {
  int successes;
  double rate;
  std::optional<Interval> interval;  ///< none in a run that may stop early
};

/// Index of a figure in the results of an episode.
struct FigureIndex {
  std::size_t rollout;   ///< in EpisodeResult::rollouts
  std::size_t quantity;  ///< in kQuantities
};

/// Values of a figure, of the episodes that have it.
std::vector<double> samplesOf(const std::vector<EpisodeResult>& episodes, const FigureIndex& figure);

/// Size of an unseen sample that the intervals of a figure count in (sim2sim_statistics/tails.hpp). Of a divergence it
/// is the mean of its null model in the same rollout; of a figure of pushes, the width of its range; of others there is
/// none.
std::optional<double> extremeOf(const std::vector<EpisodeResult>& episodes, const FigureIndex& figure);

/// Mean of a quantity, with the interval that fits it. Of one that is never negative: Gaffke's with an `extreme`
/// (tailMeanInterval(); a divergence without has none), else log-t. Of a signed one: pairedDifference(). NaN without
/// samples.
Estimate meanOf(const std::vector<double>& samples, const Quantity& quantity, const std::optional<double>& extreme);

/// Mean of a figure, with the interval that fits it; NaN if no episode has it. A run that may stop early has no
/// interval.
Estimate meanOf(const Protocol& protocol, const std::vector<EpisodeResult>& episodes, const FigureIndex& figure);

/// Median of the samples, with its interval likewise.
Estimate medianOf(const Protocol& protocol, std::vector<double> samples);

/// Paired differences of two figures, more - less, of the episodes that have both. The two may be of one run, or of two
/// runs over the same episodes.
std::vector<double> differencesOf(const std::vector<EpisodeResult>& more, const FigureIndex& of_more,
                                  const std::vector<EpisodeResult>& less, const FigureIndex& of_less);

/// Paired successes of two rollouts, of one run or of two runs over the same episodes.
PairTable pairsOf(const std::vector<EpisodeResult>& first, std::size_t rollout_in_first,
                  const std::vector<EpisodeResult>& second, std::size_t rollout_in_second);

/// Successes of engine and reference over the same episodes. With repeats intervals and p are those by start
/// (sim2sim_statistics/repeats.hpp).
struct Outcomes {
  PairTable table;                              ///< first: the reference
  int starts = 0;                               ///< independent units
  std::optional<Interval> difference_interval;  ///< of the engine's rate minus the reference's: Tango's
  std::optional<double> p;                      ///< McNemar's test, mid-p: are the rates equal?
  std::optional<double> p_exact;                ///< none with repeats
  std::optional<double> transfer;               ///< engine over reference success; none if the reference never succeeds
  std::optional<Interval> transfer_interval;    ///< Tang's
};

/// Outcomes of independent episodes.
Outcomes outcomesOf(const PairTable& table);

/// Outcomes of a closed loop beside those of the reference; of a run that may stop early counts and transfer alone.
Outcomes outcomesOf(const Protocol& protocol, const std::vector<EpisodeResult>& episodes, std::size_t rollout);

/// A divergence and its null model over the same steps: a tee that never moves.
struct DivergencePair {
  const char* divergence;  ///< names in kQuantities
  const char* null_model;
};

/// A divergence with its null model in kQuantities.
constexpr DivergencePair withNullModel(std::string_view divergence) {
  const Quantity& quantity = kQuantities[quantityIndex(divergence)];
  return {quantity.name, quantity.null_model};
}

/// The divergences of each horizon, position before angle. Those of the whole episode, kWholeEpisodePairs, come first.
inline constexpr std::array kDivergencePairs = {
    withNullModel("mean_position_divergence"),     withNullModel("mean_angle_divergence"),
    withNullModel("early_position_divergence"),    withNullModel("early_angle_divergence"),
    withNullModel("early_5s_position_divergence"), withNullModel("early_5s_angle_divergence"),
};
constexpr std::size_t kWholeEpisodePairs = 2;

/// Steps over which divergences are averaged.
struct Horizon {
  const char* title;       ///< "first 2 s"
  std::size_t first_pair;  ///< index in kDivergencePairs of the position; the angle follows
};

/// Horizons as a table shows them: the one that all episodes have in common leads. A mean over whole episodes mixes how
/// far the dynamics diverge with how long the episodes are, and that depends on success.
inline constexpr std::array kHorizons = {Horizon{"first 2 s", 2}, Horizon{"first 5 s", 4}, Horizon{"whole episode", 0}};

/// Comparison of a mean divergence with its baselines, the null model and the floor. NaN if there is none.
struct BaselineComparison {
  int episodes = 0;  ///< number of episodes that have the divergence
  int starts = 0;    ///< number of starts that have it
  Estimate median{};
  Difference minus_null{};                                             ///< divergence - null model, episode by episode
  double share_of_null = std::numeric_limits<double>::quiet_NaN();     ///< ratio of the means
  double over_floor = std::numeric_limits<double>::quiet_NaN();        ///< multiples of the mean of the widest floor
  std::optional<Interval> over_floor_interval{};                       ///< of the floor itself: none
  double share_of_largest = std::numeric_limits<double>::quiet_NaN();  ///< shareOfLargest() of the divergence
  /// Multiple of the model variant whose mean is the largest; a variant itself has no interval.
  double over_variants = std::numeric_limits<double>::quiet_NaN();
  /// Interval of the multiple, whichever variant is the largest in truth: Bonferroni's over all variants.
  std::optional<Interval> over_variants_interval{};

  /// Whether the largest 5 % of at least kFewestOfTail starts make more than half of the mean. Methods change where
  /// isCarriedByFew() says so, which is earlier.
  bool isMostlyOfLargest() const;

  /// Whether the divergence is shown to be less than the null model's; empty without an interval.
  std::optional<bool> beatsNull() const;
};

/// Success of the policy in a model variant, beside that in the reference.
struct ClosedVariant {
  std::size_t rollout;  ///< in EpisodeResult::rollouts
  SuccessRate success;
  Outcomes outcomes;                   ///< the variant as the engine; no transfer
  std::optional<double> adjusted_p{};  ///< Outcomes::p after Holm, over all variants
};

/// Variances of the figures that start and noise decide, by source. NaN without starts of two episodes or more.
struct NoiseSplits {
  NoiseSplit reference;                                    ///< success, with intervals
  NoiseSplit engine;                                       ///< likewise
  std::array<NoiseSplit, kWholeEpisodePairs> divergences;  ///< of the replay over whole episodes [m^2], [rad^2]
};

/// Figures of a run. With repeats the unit of all intervals is the start, and of means and medians, too: a start counts
/// with the mean over its episodes. Rates and transfer are over all episodes. A run that may stop early has no
/// intervals and no p-values: they hold for one number of episodes that was chosen before. transferSequence() holds
/// there.
struct Summary {
  using Means = std::array<Estimate, kQuantities.size()>;
  using Baselines = std::array<BaselineComparison, kDivergencePairs.size()>;

  int episodes = 0;
  SuccessRate reference{};
  SuccessRate engine{};
  Outcomes outcomes{};
  EndingsOfPairs endings{};
  std::vector<Means> means;          ///< by rollout, over the episodes that have the quantity; NaN if none has
  std::vector<Baselines> baselines;  ///< by rollout; NaN for the reference
  std::vector<ClosedVariant> closed_variants{};
  FirstDivergences first_divergences{};  ///< those of the replay in open loop
  std::optional<FirstDivergences>
      floor{};             ///< those of the widest floor, of the reference from itself; empty without floors
  int unmoved_floors = 0;  ///< episodes whose narrowest floor has divergence 0
  std::optional<NoiseSplits> noise{};  ///< none without repeats

  const Estimate& mean(std::size_t rollout, std::string_view quantity) const {
    return means.at(rollout)[quantityIndex(quantity)];
  }
};

/// Summarizes at least one episode of the protocol, in index order.
Summary summarize(const Protocol& protocol, const std::vector<EpisodeResult>& episodes);

}  // namespace sim2sim
