// SPDX-License-Identifier: BSD-3-Clause
#include "pair_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "wilson.hpp"

namespace sim2sim {
namespace {

/// Agreement of the pairs of one bin, by policy: each pair counts for both of its policies.
struct Tally {
  int pairs = 0;
  double agreeing = 0.0;

  void add(double agreement) {
    ++pairs;
    agreeing += agreement;
  }
  double share() const { return agreeing / pairs; }
};

std::optional<Interval> shareInterval(const Tally& all, const std::vector<Tally>& by_policy) {
  Values left_out;
  for (const Tally& of_policy : by_policy) {
    if (of_policy.pairs == all.pairs) {
      return std::nullopt;  // one policy is in every pair: the others say nothing of each other
    }
    if (of_policy.pairs > 0) {
      left_out.push_back((all.agreeing - of_policy.agreeing) / (all.pairs - of_policy.pairs));
    }
  }
  if (all.pairs < kFewestPairs || left_out.size() < kFewestPolicies) {
    return std::nullopt;
  }
  const double variance = jackknifeVariance(left_out);
  const double spread = all.share() * (1.0 - all.share());
  const auto policies = static_cast<double>(left_out.size());
  // Pairs that share no policy are half as many as the policies.
  const double independent = variance > 0.0 && spread > 0.0 ? std::min(spread / variance, policies) : 0.5 * policies;
  const Interval interval = wilson(all.share(), independent, studentsCritical(left_out.size()));
  return Interval{std::max(0.0, interval.low), std::min(1.0, interval.high)};
}

}  // namespace

PairAgreement agreementOf(const PolicyRates& rates, double from, double to) {
  Tally all;
  std::vector<Tally> by_policy(rates.test.size());
  for (std::size_t i = 0; i < rates.test.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double difference = std::abs(rates.reference[i] - rates.reference[j]);
      if (difference <= kSame || difference < from - kSame || difference >= to - kSame) {
        continue;
      }
      const int product = order(rates.reference[i], rates.reference[j]) * order(rates.test[i], rates.test[j]);
      const double agreement = 0.5 * (1.0 + product);
      all.add(agreement);
      by_policy[i].add(agreement);
      by_policy[j].add(agreement);
    }
  }
  if (all.pairs == 0) {
    return {from, to, 0, {}};
  }
  return {from, to, all.pairs, {all.share(), shareInterval(all, by_policy)}};
}

}  // namespace sim2sim
