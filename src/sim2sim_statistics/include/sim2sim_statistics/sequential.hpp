// SPDX-License-Identifier: BSD-3-Clause
/// Watching a comparison while it runs, and stopping it as soon as the answer is known. However often one looks, and
/// whenever one stops, the answer is wrong in at most 5 % of runs.
/// Each test bets against a hypothesis at odds that would be fair if it held, from a wealth of 1. The hypothesis is
/// rejected when the wealth (the e-value) reaches 20, or 40 where there are two sides. Functions give its natural
/// logarithm. Source: J. Ville, "Étude critique de la notion de collectif" (1939), for the inequality.
#pragma once

#include <array>
#include <optional>

#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"

namespace sim2sim {

constexpr double kErrorRate = 0.05;  ///< of every verdict below, over all looks together

/// Verdict on a share of the reference's success.
enum class Verdict { kUndecided, kKeeps, kDoesNot };

/// Money that is bet on engine - share * reference, or against it, pair by pair, with ten stakes at once.
class Bets {
 public:
  /// `share` > 0; `direction` 1 for, -1 against.
  Bets(double share, int direction);

  /// ln of the money after these pairs, begun with 1.
  double logMoney(const PairTable& counts) const;

 private:
  /// ln of what a pair of each kind multiplies the money by.
  struct Factors {
    double both;
    double first_only;
    double second_only;
  };
  static constexpr int kStakes = 10;
  std::array<Factors, kStakes> stakes_;
};

/// Does the engine keep at least the given share of the reference's success: engine rate >= share * reference rate?
/// Decided as soon as transferSequence() leaves the share out, so that the verdict follows from that interval.
/// Source: I. Waudby-Smith and A. Ramdas, "Estimating means of bounded random variables by betting" (JRSS B, 2024).
class TransferBet {
 public:
  /// `share` in (0, 1].
  explicit TransferBet(double share);

  /// One more pair, in the order of the episodes.
  void add(bool reference, bool engine);

  const PairTable& counts() const { return counts_; }
  /// Once decided, the verdict stays.
  Verdict verdict() const { return verdict_; }
  /// [pairs] none while undecided.
  std::optional<int> decidedAfter() const { return decided_after_; }
  /// Of the evidence so far that it keeps more, and that it keeps less.
  double logMore() const { return more_.logMoney(counts_); }
  double logLess() const { return less_.logMoney(counts_); }

 private:
  Bets more_;
  Bets less_;
  PairTable counts_;
  Verdict verdict_ = Verdict::kUndecided;
  std::optional<int> decided_after_;
};

/// Of transfer, engine rate / reference rate: the shares that neither bet has refuted, each at kErrorRate / 2. It may
/// be computed after every pair: all these intervals hold the truth together with probability kConfidence. The upper
/// end is infinity until the reference has succeeded a few times.
Interval transferSequence(const PairTable& counts);

/// Is there any difference between two success rates? McNemar's coin, thrown for each pair in which only one succeeds,
/// against all unfair coins, each as probable as the others.
/// Source: H. Robbins, "Statistical Methods Related to the Law of the Iterated Logarithm" (Annals of Mathematical
/// Statistics, 1970).
class AnyDifference {
 public:
  void add(bool first, bool second);

  const PairTable& counts() const { return counts_; }
  /// Once told apart, they stay so.
  bool differ() const { return decided_after_.has_value(); }
  /// [pairs] none while undecided.
  std::optional<int> decidedAfter() const { return decided_after_; }
  double logEvidence() const;

 private:
  PairTable counts_;
  std::optional<int> decided_after_;
};

/// Sign of a mean difference, as far as it is decided.
enum class Sign { kUndecided, kNegative, kPositive };

/// Does A diverge less than B? The sign of the mean of their paired differences, A - B, in any unit.
/// The intervals hold together only about as often as they say, for metres have no bound that one could bet on. Not
/// for successes, where that is unsafe.
/// Source: I. Waudby-Smith, D. Arbour, R. Sinha, E. H. Kennedy and A. Ramdas, "Time-uniform central limit theory and
/// asymptotic confidence sequences" (Annals of Statistics, 2024).
class DifferenceSequence {
 public:
  static constexpr int kBurnIn = 50;  ///< [pairs] before there is an interval: the central limit takes its time
  /// [pairs] at which the interval is tightest. Elsewhere it holds as well, but is wider: a plan, not a bound.
  static constexpr int kTightestAt = 500;

  /// A finite difference.
  void add(double difference);

  int pairs() const { return pairs_; }
  double mean() const { return mean_; }
  /// After the last pair; none during the burn-in, and none while all differences are the same to within kSame.
  std::optional<Interval> interval() const;
  /// Once decided, the sign stays.
  Sign sign() const { return sign_; }
  /// [pairs] none while undecided.
  std::optional<int> decidedAfter() const { return decided_after_; }

 private:
  int pairs_ = 0;
  double mean_ = 0.0;
  double squares_ = 0.0;  ///< of what the differences are away from their mean, in sum
  Sign sign_ = Sign::kUndecided;
  std::optional<int> decided_after_;
};

}  // namespace sim2sim
