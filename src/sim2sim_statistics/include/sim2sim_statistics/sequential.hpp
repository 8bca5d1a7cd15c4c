// SPDX-License-Identifier: BSD-3-Clause
/// Sequential tests: a comparison may be watched while it runs, and stopped as soon as it is decided. At most 5 % of
/// runs are decided wrongly, however often one looks and whenever one stops. Each test bets against a hypothesis, at
/// odds that are fair if it holds, from a wealth of 1. It rejects the hypothesis when the wealth (the e-value) reaches
/// 20, or 40 if there are two sides. Functions give the natural logarithm of the wealth. Source: J. Ville, "Étude
/// critique de la notion de collectif" (1939), for the inequality. Functions throw std::domain_error, with value and
/// rule, for input out of range.
#pragma once

#include <array>
#include <optional>

#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/pairs.hpp"

namespace sim2sim {

/// Error rate of every verdict below, over all looks together.
constexpr double kErrorRate = 0.05;

/// Verdict on whether the engine keeps a share of the reference's success.
enum class Verdict { kUndecided, kKeeps, kDoesNot };

/// Wealth from betting on engine - share * reference, or against it, pair by pair, averaged over ten stakes.
class Bets {
 public:
  /// `share` > 0; `direction` 1 for, -1 against.
  Bets(double share, int direction);

  /// ln of the wealth after these pairs, from a wealth of 1.
  double logMoney(const PairTable& counts) const;

 private:
  /// ln of the factor of the wealth for a pair of each kind.
  struct Factors {
    double both;
    double first_only;
    double second_only;
  };
  static constexpr int kStakes = 10;
  std::array<Factors, kStakes> stakes_;
};

/// Sequential test of whether the engine keeps a given share of the reference's success: engine rate >= share *
/// reference rate. It is decided as soon as transferSequence() excludes the share, so that the verdict follows from
/// that interval. Source: I. Waudby-Smith and A. Ramdas, "Estimating means of bounded random variables by betting"
/// (JRSS B, 2024).
class TransferBet {
 public:
  /// `share` in (0, 1].
  explicit TransferBet(double share);

  /// Adds the successes of the next episode.
  void add(bool reference, bool engine);

  const PairTable& counts() const { return counts_; }
  /// Verdict so far. Once decided, it stays.
  Verdict verdict() const { return verdict_; }
  /// [pairs] Number after which it was decided; none while undecided.
  std::optional<int> decidedAfter() const { return decided_after_; }
  /// ln of the wealth of the bets that the engine keeps more than the share, and that it keeps less.
  double logMore() const { return more_.logMoney(counts_); }
  double logLess() const { return less_.logMoney(counts_); }

 private:
  Bets more_;
  Bets less_;
  PairTable counts_;
  Verdict verdict_ = Verdict::kUndecided;
  std::optional<int> decided_after_;
};

/// Confidence sequence of the transfer, engine rate / reference rate: the shares that neither bet has rejected, each at
/// kErrorRate / 2. The intervals after all pairs hold the truth together with probability kConfidence. The upper end is
/// infinity until the reference has succeeded a few times.
Interval transferSequence(const PairTable& counts);

/// Sequential test of whether two success rates differ: McNemar's fair coin, for each pair in which only one succeeds,
/// against a uniform prior over all other coins.
/// Source: H. Robbins, "Statistical Methods Related to the Law of the Iterated Logarithm" (Annals of Mathematical
/// Statistics, 1970).
class AnyDifference {
 public:
  /// Adds the successes of the next episode.
  void add(bool first, bool second);

  const PairTable& counts() const { return counts_; }
  /// Whether the rates differ. Once decided, it stays.
  bool differ() const { return decided_after_.has_value(); }
  /// [pairs] Number after which it was decided; none while undecided.
  std::optional<int> decidedAfter() const { return decided_after_; }
  /// ln of the wealth of the bet against equal rates.
  double logEvidence() const;

 private:
  PairTable counts_;
  std::optional<int> decided_after_;
};

/// Sign of a mean difference.
enum class Sign { kUndecided, kNegative, kPositive };

/// Sequential test of the sign of a mean of paired differences, A - B, in any unit: does A diverge less than B?
/// Coverage is asymptotic, because such differences have no bound to bet on. Not for successes, where that is unsafe.
/// Source: I. Waudby-Smith, D. Arbour, R. Sinha, E. H. Kennedy and A. Ramdas, "Time-uniform central limit theory and
/// asymptotic confidence sequences" (Annals of Statistics, 2024).
class DifferenceSequence {
 public:
  static constexpr int kBurnIn = 50;  ///< [pairs] before there is an interval: the central limit takes its time
  /// [pairs] Planned number, at which the interval is closest to that of a test with a fixed number of pairs. With
  /// fewer or more pairs it holds as well, but wastes more.
  static constexpr int kTightestAt = 500;

  /// Adds a finite difference.
  void add(double difference);

  int pairs() const { return pairs_; }
  double mean() const { return mean_; }
  /// Interval of the mean after the last pair; none during the burn-in, or while all differences are equal to within
  /// kSame.
  std::optional<Interval> interval() const;
  /// Sign of the mean. Once decided, it stays.
  Sign sign() const { return sign_; }
  /// [pairs] Number after which it was decided; none while undecided.
  std::optional<int> decidedAfter() const { return decided_after_; }

 private:
  int pairs_ = 0;
  double mean_ = 0.0;
  double squares_ = 0.0;  ///< sum of squared deviations from the mean
  Sign sign_ = Sign::kUndecided;
  std::optional<int> decided_after_;
};

}  // namespace sim2sim
