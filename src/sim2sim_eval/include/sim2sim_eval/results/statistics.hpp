// SPDX-License-Identifier: BSD-3-Clause
/// How sure a figure is.
#pragma once

#include <limits>
#include <optional>
#include <vector>

namespace sim2sim {

constexpr double kConfidence = 0.95;  ///< of every interval in a report

struct Interval {
  double low;
  double high;
};

/// Wilson's score interval of a success probability, from `successes` of `trials` > 0.
/// Source: E. B. Wilson, "Probable Inference, the Law of Succession, and Statistical Inference" (1927).
Interval wilsonInterval(int successes, int trials);

struct Mean {
  double value = std::numeric_limits<double>::quiet_NaN();
  std::optional<Interval> interval;  ///< Student's t over the samples; none for fewer than two of them
};

/// The part of the interval that a mean of distances can lie in: Student's t knows nothing of zero.
std::optional<Interval> aboveZero(const std::optional<Interval>& interval);

/// Of at least one sample, summed in order.
Mean meanOf(const std::vector<double>& samples);

}  // namespace sim2sim
