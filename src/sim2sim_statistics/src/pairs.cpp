// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/pairs.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

/// The counts of a table by the letters of the papers.
struct Counts {
  double a;  ///< both
  double b;  ///< second only
  double c;  ///< first only
  double n;  ///< pairs
};

Counts countsOf(const PairTable& table) {
  table.validate();
  return {static_cast<double>(table.both), static_cast<double>(table.second_only),
          static_cast<double>(table.first_only), static_cast<double>(table.pairs())};
}

/// The larger root of a x^2 + b x + c, a > 0, computed without the difference of nearly equal numbers. It has one here:
/// a discriminant below zero is rounding.
double largerRoot(double a, double b, double c) {
  const double root = std::sqrt(std::max(0.0, b * b - 4.0 * a * c));
  return b > 0.0 ? -2.0 * c / (b + root) : (root - b) / (2.0 * a);
}

/// Whether a score, divided by its standard deviation under the hypothesis, does not reject the hypothesis.
bool isLikely(double score, double variance) {
  static const double z = boost::math::quantile(boost::math::normal(), 0.5 * (1.0 + kConfidence));
  return std::abs(score) <= z * std::sqrt(std::max(0.0, variance));
}

/// Tango's score of the hypothesis that the rates differ by d. q is how probable a pair of the kind "first only" most
/// likely is if they do.
bool isLikelyDifference(const Counts& t, double d) {
  const double q = largerRoot(2.0 * t.n, -t.b - t.c + (2.0 * t.n - t.b + t.c) * d, -t.c * d * (1.0 - d));
  return isLikely(t.b - t.c - t.n * d, t.n * (2.0 * q + d * (1.0 - d)));
}

/// Tang's score of the hypothesis that the rates have the ratio f; q as above.
bool isLikelyRatio(const Counts& t, double f) {
  const double succeeding = t.a + t.b + t.c;
  const double q =
      largerRoot(t.n * (1.0 + f), (t.a + t.c) * f * f - (t.a + t.b + 2.0 * t.c), t.c * (1.0 - f) * succeeding / t.n);
  return isLikely(t.a + t.b - (t.a + t.c) * f, t.n * (1.0 + f) * q + succeeding * (f - 1.0));
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
  const double seen = (t.b - t.c) / t.n;
  const auto likely = [&](double d) { return isLikelyDifference(t, d); };
  return Interval{edge(likely, seen, -1.0), edge(likely, seen, 1.0)};
}

std::optional<Interval> tangInterval(const PairTable& table) {
  const Counts t = countsOf(table);
  if (t.n < kFewestEpisodes || t.a + t.c == 0.0) {
    return std::nullopt;
  }
  // Bounds of the logarithm, far beyond the ratios that any number of pairs could tell from 0 and from infinity.
  constexpr double kFarthest = 40.0;
  const double seen = (t.a + t.b) / (t.a + t.c);
  const auto likely = [&](double log_ratio) { return isLikelyRatio(t, std::exp(log_ratio)); };
  const double inside = seen > 0.0 ? std::log(seen) : -kFarthest;
  return Interval{seen > 0.0 ? std::exp(edge(likely, inside, -kFarthest)) : 0.0,
                  std::exp(edge(likely, inside, kFarthest))};
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
