// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/sequential.hpp"

#include <algorithm>
#include <array>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

/// The share of a bet, which a share of 0 or of infinity would not be.
double checked(double share) {
  if (!(share > 0.0 && share <= 1.0)) {
    refuse("share", share, "above 0 and at most 1");
  }
  return share;
}

}  // namespace

Bets::Bets(double share, int direction) : stakes_() {
  // Beyond 1 a stake could lose more than all. There the two change places: that the engine keeps more than `share` is
  // that the reference keeps less than 1 / share.
  const bool swapped = share > 1.0;
  const double x = swapped ? 1.0 / share : share;
  for (int j = 0; j < kStakes; ++j) {
    // 5, 15 ... 95 % of the money, each with a tenth of it: which is best depends on the truth.
    const double stake = (swapped ? -direction : direction) * (j + 0.5) / kStakes;
    const double win = std::log1p(stake);
    const double loss = std::log1p(-stake * x);
    stakes_.at(j) = {std::log1p(stake * (1.0 - x)), swapped ? win : loss, swapped ? loss : win};
  }
}

double Bets::logMoney(const PairTable& counts) const {
  std::array<double, kStakes> logs{};
  std::transform(stakes_.begin(), stakes_.end(), logs.begin(), [&counts](const Factors& factors) {
    return counts.both * factors.both + counts.first_only * factors.first_only +
           counts.second_only * factors.second_only;
  });
  const double greatest = *std::max_element(logs.begin(), logs.end());  // taken out, so that no exp overflows
  const double sum = std::accumulate(logs.begin(), logs.end(), 0.0,
                                     [greatest](double total, double log) { return total + std::exp(log - greatest); });
  return greatest + std::log(sum / kStakes);
}

TransferBet::TransferBet(double share) : more_(checked(share), 1), less_(share, -1) {}

void TransferBet::add(bool reference, bool engine) {
  counts_.add(reference, engine);
  if (verdict_ != Verdict::kUndecided) {
    return;
  }
  const double enough = -std::log(0.5 * kErrorRate);  // as transferSequence(), so that the two agree
  if (logMore() >= enough) {
    verdict_ = Verdict::kKeeps;
  } else if (logLess() >= enough) {
    verdict_ = Verdict::kDoesNot;
  } else {
    return;
  }
  decided_after_ = counts_.pairs();
}

Interval transferSequence(const PairTable& counts) {
  counts.validate();
  // Bounds of ln share, far beyond what any number of pairs could tell from 0 and from infinity.
  constexpr double kFarthest = 40.0;
  const double enough = -std::log(0.5 * kErrorRate);
  const auto unrefuted = [&](int direction) {
    return [&counts, enough, direction](double log_share) {
      return Bets(std::exp(log_share), direction).logMoney(counts) < enough;
    };
  };
  // Where the bets come out even: no money is made there. It is an end of the scale where one of the two never
  // succeeds.
  const double seen = std::log(static_cast<double>(counts.both + counts.second_only)) -
                      std::log(static_cast<double>(counts.both + counts.first_only));
  const double inside = std::isnan(seen) ? 0.0 : std::clamp(seen, -kFarthest, kFarthest);
  const double low = edge(unrefuted(1), inside, -kFarthest);
  const double high = edge(unrefuted(-1), inside, kFarthest);
  return {low == -kFarthest ? 0.0 : std::exp(low),
          high == kFarthest ? std::numeric_limits<double>::infinity() : std::exp(high)};
}

void AnyDifference::add(bool first, bool second) {
  counts_.add(first, second);
  if (!decided_after_ && logEvidence() >= -std::log(kErrorRate)) {
    decided_after_ = counts_.pairs();
  }
}

double AnyDifference::logEvidence() const {
  using boost::math::lgamma;
  const double b = counts_.second_only;
  const double c = counts_.first_only;
  return lgamma(1.0 + b) + lgamma(1.0 + c) - lgamma(2.0 + b + c) + (b + c) * std::log(2.0);
}

void DifferenceSequence::add(double difference) {
  if (!std::isfinite(difference)) {
    refuse("difference", difference, "a finite number");
  }
  // Source: B. P. Welford, "Note on a Method for Calculating Corrected Sums of Squares and Products" (1962).
  ++pairs_;
  const double from_old_mean = difference - mean_;
  mean_ += from_old_mean / pairs_;
  squares_ += from_old_mean * (difference - mean_);

  const std::optional<Interval> now = interval();
  if (sign_ == Sign::kUndecided && now && (now->low > 0.0 || now->high < 0.0)) {
    sign_ = now->low > 0.0 ? Sign::kPositive : Sign::kNegative;
    decided_after_ = pairs_;
  }
}

std::optional<Interval> DifferenceSequence::interval() const {
  const double deviation = std::sqrt(squares_ / (pairs_ - 1.0));
  if (pairs_ < kBurnIn || deviation <= kSame) {
    return std::nullopt;
  }
  const double log_error = std::log(kErrorRate);
  const double rho_squared = (-2.0 * log_error + std::log(1.0 - 2.0 * log_error)) / kTightestAt;
  const double grown = pairs_ * rho_squared + 1.0;
  const double half_width =
      deviation * std::sqrt(2.0 * grown / (pairs_ * (pairs_ * rho_squared)) * (0.5 * std::log(grown) - log_error));
  return Interval{mean_ - half_width, mean_ + half_width};
}

}  // namespace sim2sim
