// SPDX-License-Identifier: BSD-3-Clause
/// Equivalent of a loss: how large a known error must be to cost as much as something else does.
#pragma once

#include <vector>

#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// What is left over what is compared at one size of an error: success with this error, less the success that is to be
/// explained. It falls as the error grows.
struct Surplus {
  double size;  ///< of the error, in any unit
  double value;
  Interval interval;
};

/// Size of an error at which nothing is left over. Infinity: it is larger than the largest that was tried.
struct EquivalentSize {
  double value;
  Interval interval;  ///< its lower end is the smallest size that was tried, or larger
};

/// Size at which the surplus, linear between the sizes that were tried, falls to 0 first. Its interval has the sizes
/// that the intervals of the surplus do not exclude: from where the lower end falls to 0 first, to where the upper end
/// does last. So it covers the truth at each size that was tried as often as those do.
/// `surplus` has at least two sizes, in rising order. Throws std::domain_error otherwise.
/// Source: E. C. Fieller, "Some Problems in Interval Estimation" (1954), of inverted tests.
EquivalentSize equivalentSize(const std::vector<Surplus>& surplus);

}  // namespace sim2sim
