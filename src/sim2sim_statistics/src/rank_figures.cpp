// SPDX-License-Identifier: BSD-3-Clause
#include "rank_figures.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <string>

#include "sim2sim_statistics/common.hpp"
#include "sim2sim_statistics/intervals.hpp"
#include "sim2sim_statistics/planning.hpp"
#include "sim2sim_statistics/ranking.hpp"

namespace sim2sim {
namespace {

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

}  // namespace

bool hasSpread(const Values& values) {
  return std::any_of(values.begin(), values.end(), [&](double value) { return value != values.front(); });
}

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

double jackknifeVariance(const Values& left_out) {
  const auto n = static_cast<double>(left_out.size());
  return square(n - 1.0) / n * square(standardDeviation(left_out));
}

double studentsCritical(std::size_t samples) {
  const boost::math::students_t t(static_cast<double>(samples - 1));
  return quantile(t, 0.5 * (1.0 + kConfidence));
}

PolicyRates PolicyRates::without(std::size_t policy) const {
  PolicyRates others = *this;
  others.reference.erase(others.reference.begin() + static_cast<std::ptrdiff_t>(policy));
  others.test.erase(others.test.begin() + static_cast<std::ptrdiff_t>(policy));
  return others;
}

bool PolicyRates::spreadWithoutAny() const {
  for (std::size_t policy = 0; policy < test.size(); ++policy) {
    const PolicyRates others = without(policy);
    if (!hasSpread(others.reference) || !hasSpread(others.test)) {
      return false;
    }
  }
  return true;
}

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

}  // namespace sim2sim
