// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/ranking.hpp"

#include <algorithm>
#include <boost/math/constants/constants.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <string>
#include <utility>

#include "pair_agreement.hpp"
#include "rank_figures.hpp"
#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/planning.hpp"

namespace sim2sim {
namespace {

constexpr double kPi = boost::math::constants::pi<double>();

double normalCritical() {
  static const double z = quantile(boost::math::normal(), 0.5 * (1.0 + kConfidence));
  return z;
}

// The noise of the starts.

/// Reliability of the mean of a row: part of its variance that is not the residuals'.
double reliabilityOf(const MeanSquares& squares) {
  return squares.rows > 0.0 ? 1.0 - squares.residual / squares.rows : kNotANumber;
}

/// Change of a correlation by the noise of the starts.
struct Attenuation {
  double reference_reliability;
  double test_reliability;
  double shared;  ///< correlation that noise common to both simulators adds

  /// Correlation of the true rates, from that of the measured ones.
  double undo(double measured) const {
    return std::clamp((measured - shared) / std::sqrt(reference_reliability * test_reliability), -1.0, 1.0);
  }
};

Attenuation attenuationOf(const CrossedTable& reference, const CrossedTable& test) {
  const MeanSquares of_reference = meanSquares(reference);
  const MeanSquares of_test = meanSquares(test);
  const double of_sum = meanSquares(reference.plus(1.0, test)).residual;
  const double shared = 0.5 * (of_sum - of_reference.residual - of_test.residual);
  return {reliabilityOf(of_reference), reliabilityOf(of_test), shared / std::sqrt(of_reference.rows * of_test.rows)};
}

// Intervals of correlations.

/// Greiner's relation of Kendall's tau to Pearson's correlation of normal values.
double pearsonOfKendall(double tau) { return std::sin(0.5 * kPi * tau); }
double kendallOfPearson(double r) { return 2.0 / kPi * std::asin(r); }
/// Likewise of Spearman's correlation.
double pearsonOfSpearman(double rho) { return 2.0 * std::sin(kPi / 6.0 * rho); }
double spearmanOfPearson(double r) { return 6.0 / kPi * std::asin(0.5 * r); }

/// Excess of the standard deviation of a correlation over that of normal policies, by the jackknife over policies; at
/// least 1.
template <class Correlation>
double excessOf(const PolicyRates& rates, const Correlation& correlation_of, double normal_variance) {
  Values left_out;
  for (std::size_t policy = 0; policy < rates.test.size(); ++policy) {
    const PolicyRates others = rates.without(policy);
    left_out.push_back(correlation_of(others.reference, others.test));
  }
  return normal_variance > 0.0 ? std::sqrt(std::max(1.0, jackknifeVariance(left_out) / normal_variance)) : 1.0;
}

/// Interval of a correlation `r` on the scale of Fisher's z, whose variance is that of normal policies.
template <class Correlation>
Interval zInterval(const PolicyRates& rates, const Correlation& correlation_of, double r, double variance_of_z) {
  const double excess = excessOf(rates, correlation_of, variance_of_z * square(1.0 - r * r));
  const double half_width = normalCritical() * excess * std::sqrt(variance_of_z);
  return {std::tanh(std::atanh(r) - half_width), std::tanh(std::atanh(r) + half_width)};
}

Interval holding(const Interval& interval, double value) {
  return {std::min(interval.low, value), std::max(interval.high, value)};
}

Interval pearsonInterval(const PolicyRates& rates, double r, const Attenuation& noise) {
  const double variance_of_z = 1.0 / (static_cast<double>(rates.test.size()) - 3.0);
  const Interval measured = zInterval(rates, pearson, r, variance_of_z);
  const Interval corrected = {noise.undo(measured.low), noise.undo(measured.high)};
  return holding(holding(corrected, measured.low), measured.high);
}

Interval spearmanInterval(const PolicyRates& rates, double rho, const Attenuation& noise) {
  const auto n = static_cast<double>(rates.test.size());
  const double half_a_swap = 6.0 / (n * (n * n - 1.0));
  const double capped = std::clamp(rho, -1.0 + half_a_swap, 1.0 - half_a_swap);
  const Interval measured = zInterval(rates, spearman, capped, (1.0 + 0.5 * capped * capped) / (n - 3.0));
  const auto corrected = [&](double end) { return spearmanOfPearson(noise.undo(pearsonOfSpearman(end))); };
  return holding({corrected(measured.low), corrected(measured.high)}, rho);
}

/// Standard deviation of the tau of n policies, if they are normal and the population's is `tau`.
double kendallDeviation(double tau, double n) {
  const double r = pearsonOfKendall(tau);
  const double triples = 1.0 / 9.0 - square(2.0 / kPi * std::asin(0.5 * r));
  return std::sqrt(std::max(0.0, 2.0 / (n * (n - 1.0)) * (1.0 - tau * tau + 2.0 * (n - 2.0) * triples)));
}

Interval kendallInterval(const PolicyRates& rates, double tau, const Attenuation& noise) {
  const auto n = static_cast<double>(rates.test.size());
  const double excess = excessOf(rates, kendallTauB, square(kendallDeviation(tau, n)));
  const auto is_likely = [&](double truth) {
    // Unrelated rankings have the same variance whatever the policies: the excess begins at 0.
    const double share = tau != 0.0 ? std::clamp(truth / tau, 0.0, 1.0) : 0.0;
    const double deviation = (1.0 + share * (excess - 1.0)) * kendallDeviation(truth, n);
    return std::abs(tau - truth) <= normalCritical() * deviation;
  };
  const Interval measured = {edge(is_likely, tau, -1.0), edge(is_likely, tau, 1.0)};
  const auto corrected = [&](double end) { return kendallOfPearson(noise.undo(pearsonOfKendall(end))); };
  return holding({corrected(measured.low), corrected(measured.high)}, tau);
}

// Interval of the rank violation.

double rootOfViolation(const PolicyRates& rates) { return std::sqrt(violation(rates.test, rates.reference)); }

/// Root of the violation of rates whose variance and correlation are the true ones: the reference's are drawn together,
/// and the test's, of which only the order counts, get that correlation by a combination with the reference's.
double rootOfViolation(const PolicyRates& measured, const Attenuation& noise) {
  const double r = correlation(measured.reference, measured.test);
  if (std::isnan(r)) {
    return 0.0;
  }
  const double true_r = noise.undo(r);
  const double rest = r * r < 1.0 ? std::sqrt((1.0 - true_r * true_r) / (1.0 - r * r)) : 0.0;
  const double shrink = std::sqrt(noise.reference_reliability);
  const double mean_of_reference = averageOf(measured.reference);
  const double mean_of_test = averageOf(measured.test);
  const double deviation_of_reference = standardDeviation(measured.reference);
  const double deviation_of_test = standardDeviation(measured.test);
  PolicyRates rates = measured;
  for (std::size_t i = 0; i < rates.test.size(); ++i) {
    const double of_reference = (measured.reference[i] - mean_of_reference) / deviation_of_reference;
    const double of_test = (measured.test[i] - mean_of_test) / deviation_of_test;
    rates.reference[i] = shrink * measured.reference[i];
    rates.test[i] = true_r * of_reference + rest * (of_test - r * of_reference);
  }
  return rootOfViolation(rates);
}

/// Successes of all policies by start: in the reference, then in the test.
class SuccessesByStart {
 public:
  SuccessesByStart(const CrossedTable& reference, const CrossedTable& test)
      : policies_(reference.rows()), starts_(reference.columns()) {
    successes_.reserve(2 * policies_ * starts_);
    for (std::size_t start = 0; start < starts_; ++start) {
      for (const CrossedTable* table : {&reference, &test}) {
        for (std::size_t policy = 0; policy < policies_; ++policy) {
          successes_.push_back(table->at(policy, start) > 0.0 ? 1 : 0);
        }
      }
    }
  }

  /// Rates from as many starts as there are, drawn with replacement, the same ones in both simulators.
  PolicyRates resampled(boost::random::mt19937& random) const {
    const boost::random::uniform_int_distribution<std::size_t> any(0, starts_ - 1);
    std::vector<std::uint32_t> sums(2 * policies_, 0);
    for (std::size_t i = 0; i < starts_; ++i) {
      const std::uint32_t* successes = &successes_[any(random) * sums.size()];
      for (std::size_t k = 0; k < sums.size(); ++k) {
        sums[k] += successes[k];
      }
    }
    Values rates(sums.begin(), sums.end());
    for (double& rate : rates) {
      rate /= static_cast<double>(starts_);
    }
    const auto middle = rates.begin() + static_cast<std::ptrdiff_t>(policies_);
    return {Values(rates.begin(), middle), Values(middle, rates.end())};
  }

 private:
  std::size_t policies_;
  std::size_t starts_;
  std::vector<std::uint32_t> successes_;
};

/// Variance of the violation's root over resampled starts.
double varianceOverStarts(const CrossedTable& reference, const CrossedTable& test, std::uint32_t seed) {
  boost::random::mt19937 random(seed);
  const SuccessesByStart successes(reference, test);
  Values roots;
  for (int resample = 0; resample < kStartResamples; ++resample) {
    roots.push_back(rootOfViolation(successes.resampled(random)));
  }
  return square(standardDeviation(roots));
}

Interval violationInterval(const PolicyRates& rates, const Attenuation& noise, double variance_over_starts) {
  Values measured;
  Values corrected;
  for (std::size_t policy = 0; policy < rates.test.size(); ++policy) {
    const PolicyRates others = rates.without(policy);
    measured.push_back(rootOfViolation(others));
    corrected.push_back(rootOfViolation(others, noise));
  }
  const double variance = std::max(jackknifeVariance(measured), jackknifeVariance(corrected)) + variance_over_starts;
  const double half_width = studentsCritical(rates.test.size()) * std::sqrt(variance);
  const double as_measured = rootOfViolation(rates);
  const double as_corrected = rootOfViolation(rates, noise);
  return {square(std::max(0.0, std::min(as_measured, as_corrected) - half_width)),
          square(std::max(as_measured, as_corrected) + half_width)};
}

RankingVerdict verdictOf(const std::optional<Interval>& kendall) {
  if (kendall && kendall->low > 0.0) {
    return RankingVerdict::kPreserved;
  }
  return kendall && kendall->high < 0.0 ? RankingVerdict::kReversed : RankingVerdict::kCannotSay;
}

void requireSuccesses(const CrossedTable& table) {
  for (std::size_t policy = 0; policy < table.rows(); ++policy) {
    for (std::size_t start = 0; start < table.columns(); ++start) {
      const double success = table.at(policy, start);
      if (success != 0.0 && success != 1.0) {
        refuse("success", success, "0 or 1");
      }
    }
  }
}

}  // namespace

RankingComparison compareRankings(const CrossedTable& reference, const CrossedTable& test, std::uint32_t seed) {
  requireSuccesses(reference);
  requireSuccesses(test);
  const Attenuation noise = attenuationOf(reference, test);
  const PolicyRates rates = {reference.rowMeans(), test.rowMeans()};
  RankingComparison comparison = {};
  comparison.reference_reliability = noise.reference_reliability;
  comparison.test_reliability = noise.test_reliability;
  comparison.pearson.value = correlation(rates.reference, rates.test);
  comparison.spearman.value = spearman(rates.reference, rates.test);
  comparison.kendall.value = kendallTauB(rates.reference, rates.test);
  comparison.violation.value = violation(rates.test, rates.reference);
  if (reference.rows() >= kFewestPolicies && reference.columns() >= kFewestColumns &&
      noise.reference_reliability > kLeastReliability && noise.test_reliability > kLeastReliability &&
      rates.spreadWithoutAny()) {
    comparison.pearson.interval = pearsonInterval(rates, comparison.pearson.value, noise);
    comparison.spearman.interval = spearmanInterval(rates, comparison.spearman.value, noise);
    comparison.kendall.interval = kendallInterval(rates, comparison.kendall.value, noise);
    comparison.violation.interval = violationInterval(rates, noise, varianceOverStarts(reference, test, seed));
  }
  for (std::size_t bin = 0; bin < kAgreementBins.size(); ++bin) {
    const bool is_last = bin + 1 == kAgreementBins.size();
    PairAgreement& agreement = comparison.agreement[bin];
    agreement = agreementOf(rates, kAgreementBins[bin], is_last ? 1.0 + 2.0 * kSame : kAgreementBins[bin + 1]);
    agreement.to = std::min(agreement.to, 1.0);
  }
  comparison.verdict = verdictOf(comparison.kendall.interval);
  return comparison;
}

double kendallPower(double tau, int policies) {
  if (!(tau > 0.0 && tau < 1.0)) {
    refuse("tau", tau, "above 0 and below 1");
  }
  if (policies < static_cast<int>(kFewestPolicies) || policies > kMostPolicies) {
    refuse("policies", policies, "from " + std::to_string(kFewestPolicies) + " to " + std::to_string(kMostPolicies));
  }
  const double critical = normalCritical() * kendallDeviation(0.0, policies);
  return cdf(boost::math::normal(), (tau - critical) / kendallDeviation(tau, policies));
}

std::optional<int> policiesForKendall(double tau) {
  int few = static_cast<int>(kFewestPolicies) - 1;
  int enough = kMostPolicies;
  if (kendallPower(tau, enough) < kPower) {
    return std::nullopt;
  }
  while (enough - few > 1) {
    const int middle = few + (enough - few) / 2;
    (kendallPower(tau, middle) >= kPower ? enough : few) = middle;
  }
  return enough;
}

}  // namespace sim2sim
