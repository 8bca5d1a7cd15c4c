// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/ranking.hpp"

#include <algorithm>
#include <boost/math/constants/constants.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/planning.hpp"

namespace sim2sim {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kPi = boost::math::constants::pi<double>();

using Values = std::vector<double>;

double square(double x) { return x * x; }

double normalCritical() {
  static const double z = quantile(boost::math::normal(), 0.5 * (1.0 + kConfidence));
  return z;
}

double studentsCritical(std::size_t samples) {
  const boost::math::students_t t(static_cast<double>(samples - 1));
  return quantile(t, 0.5 * (1.0 + kConfidence));
}

void requireTwoSides(const Values& first, const Values& second) {
  if (first.size() < 2) {
    refuse("number of values", first.size(), "at least 2");
  }
  if (second.size() != first.size()) {
    refuse("number of values", second.size(), "that of the other side, " + std::to_string(first.size()));
  }
  for (const Values* values : {&first, &second}) {
    for (const double value : *values) {
      if (!std::isfinite(value)) {
        refuse("value", value, "a finite number");
      }
    }
  }
}

double averageOf(const Values& values) { return sumOf(values) / static_cast<double>(values.size()); }

/// 1 if a > b, -1 if a < b, and 0 otherwise.
int order(double a, double b) { return (a > b ? 1 : 0) - (a < b ? 1 : 0); }

bool hasSpread(const Values& values) {
  return std::any_of(values.begin(), values.end(), [&](double value) { return value != values.front(); });
}

/// Ranks from 1; ties have the average of theirs.
Values ranksOf(const Values& values) {
  Values sorted = values;
  std::sort(sorted.begin(), sorted.end());
  Values ranks;
  for (const double value : values) {
    const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), value);
    ranks.push_back(0.5 * static_cast<double>((first - sorted.begin()) + (last - sorted.begin()) + 1));
  }
  return ranks;
}

/// Correlation of values without a check.
double correlation(const Values& first, const Values& second) {
  if (!hasSpread(first) || !hasSpread(second)) {
    return kNotANumber;
  }
  const double mean_of_first = averageOf(first);
  const double mean_of_second = averageOf(second);
  double squares_of_first = 0.0;
  double squares_of_second = 0.0;
  double products = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    squares_of_first += square(first[i] - mean_of_first);
    squares_of_second += square(second[i] - mean_of_second);
    products += (first[i] - mean_of_first) * (second[i] - mean_of_second);
  }
  return std::clamp(products / (std::sqrt(squares_of_first) * std::sqrt(squares_of_second)), -1.0, 1.0);
}

double violation(const Values& test, const Values& reference) {
  double sum = 0.0;
  for (std::size_t i = 0; i < test.size(); ++i) {
    double largest = 0.0;
    for (std::size_t j = 0; j < test.size(); ++j) {
      if ((test[i] > test[j]) != (reference[i] > reference[j])) {
        largest = std::max(largest, std::abs(reference[i] - reference[j]));
      }
    }
    sum += largest;
  }
  return sum / static_cast<double>(test.size());
}

/// Success rates of the policies.
struct PolicyRates {
  Values reference;
  Values test;

  /// Rates of all other policies.
  PolicyRates without(std::size_t policy) const {
    PolicyRates others = *this;
    others.reference.erase(others.reference.begin() + static_cast<std::ptrdiff_t>(policy));
    others.test.erase(others.test.begin() + static_cast<std::ptrdiff_t>(policy));
    return others;
  }

  /// Whether no single policy makes the whole spread of one side.
  bool spreadWithoutAny() const {
    for (std::size_t policy = 0; policy < test.size(); ++policy) {
      const PolicyRates others = without(policy);
      if (!hasSpread(others.reference) || !hasSpread(others.test)) {
        return false;
      }
    }
    return true;
  }
};

/// Jackknife's variance, from the figures without each sample in turn.
double jackknifeVariance(const Values& left_out) {
  const auto n = static_cast<double>(left_out.size());
  return square(n - 1.0) / n * square(standardDeviation(left_out));
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

// Pairs of policies.

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

/// Wilson's interval for a share of `n` trials, which need not be whole.
Interval wilsonOf(double share, double n, double z) {
  const double center = (share + z * z / (2.0 * n)) / (1.0 + z * z / n);
  const double half_width = z / (1.0 + z * z / n) * std::sqrt(share * (1.0 - share) / n + z * z / (4.0 * n * n));
  return {std::max(0.0, center - half_width), std::min(1.0, center + half_width)};
}

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
  return wilsonOf(all.share(), independent, studentsCritical(left_out.size()));
}

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

double pearson(const std::vector<double>& first, const std::vector<double>& second) {
  requireTwoSides(first, second);
  return correlation(first, second);
}

double spearman(const std::vector<double>& first, const std::vector<double>& second) {
  requireTwoSides(first, second);
  return correlation(ranksOf(first), ranksOf(second));
}

double kendallTauB(const std::vector<double>& first, const std::vector<double>& second) {
  requireTwoSides(first, second);
  double excess = 0.0;
  double untied_in_first = 0.0;
  double untied_in_second = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const int in_first = order(first[i], first[j]);
      const int in_second = order(second[i], second[j]);
      excess += in_first * in_second;
      untied_in_first += std::abs(in_first);
      untied_in_second += std::abs(in_second);
    }
  }
  const double untied = std::sqrt(untied_in_first) * std::sqrt(untied_in_second);
  return untied > 0.0 ? std::clamp(excess / untied, -1.0, 1.0) : kNotANumber;
}

double meanMaximumRankViolation(const std::vector<double>& test, const std::vector<double>& reference) {
  requireTwoSides(test, reference);
  return violation(test, reference);
}

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
