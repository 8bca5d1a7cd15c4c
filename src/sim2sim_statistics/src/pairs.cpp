// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/pairs.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "pair_scores.hpp"
#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

Counts countsOf(const PairTable& table) {
  table.validate();
  return {static_cast<double>(table.both), static_cast<double>(table.second_only),
          static_cast<double>(table.first_only), static_cast<double>(table.pairs())};
}

/// The discordant pairs as throws of a fair coin, and the rarer side of it.
struct Throws {
  boost::math::binomial coin;
  double rarer;
};

Throws throwsOf(const Counts& t) { return {boost::math::binomial(t.b + t.c, 0.5), std::min(t.b, t.c)}; }

}  // namespace

void PairTable::add(bool first, bool second) {
  int& count = first ? (second ? both : first_only) : (second ? second_only : neither);
  ++count;
}

void PairTable::validate() const {
  for (const int count : {both, first_only, second_only, neither}) {
    if (count < 0) {
      refuse("count of pairs", count, "at least 0");
    }
  }
}

std::optional<Interval> tangoInterval(const PairTable& table) {
  const Counts t = countsOf(table);
  if (t.n < kFewestEpisodes) {
    return std::nullopt;
  }
  return tango(t);
}

std::optional<Interval> tangInterval(const PairTable& table) {
  const Counts t = countsOf(table);
  if (t.n < kFewestEpisodes || t.a + t.c == 0.0) {
    return std::nullopt;
  }
  return tang(t);
}

double mcnemarExact(const PairTable& table) {
  const Throws discordant = throwsOf(countsOf(table));
  return std::min(1.0, 2.0 * cdf(discordant.coin, discordant.rarer));
}

double mcnemarMidP(const PairTable& table) {
  const Throws discordant = throwsOf(countsOf(table));
  if (discordant.coin.trials() == 0.0) {
    return 1.0;
  }
  const double point = pdf(discordant.coin, discordant.rarer);
  // With as many on either side, what was seen is counted once, not for each side.
  return table.first_only == table.second_only ? 1.0 - 0.5 * point
                                               : 2.0 * cdf(discordant.coin, discordant.rarer) - point;
}

Difference rateDifference(const PairTable& table) {
  return {table.difference(), tangoInterval(table), mcnemarMidP(table)};
}

std::vector<double> holm(const std::vector<double>& p) {
  for (const double value : p) {
    if (!(value >= 0.0 && value <= 1.0)) {
      refuse("p", value, "from 0 to 1");
    }
  }
  std::vector<std::size_t> rising(p.size());
  std::iota(rising.begin(), rising.end(), 0);
  std::stable_sort(rising.begin(), rising.end(), [&](std::size_t i, std::size_t j) { return p[i] < p[j]; });
  std::vector<double> adjusted(p.size());
  double greatest = 0.0;
  for (std::size_t rank = 0; rank < rising.size(); ++rank) {
    greatest = std::max(greatest, std::min(1.0, static_cast<double>(p.size() - rank) * p[rising[rank]]));
    adjusted[rising[rank]] = greatest;
  }
  return adjusted;
}

}  // namespace sim2sim
