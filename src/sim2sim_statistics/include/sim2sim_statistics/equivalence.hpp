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
  double value;       ///< on a line between two sizes that were tried
  Interval interval;  ///< its ends are sizes that were tried
};

/// Size at which the surplus, linear between the sizes that were tried, falls to 0 first. Its interval goes from the
/// last size up to which all surpluses are surely above 0, to the first one from which on all are surely below 0. It
/// assumes nothing of the sizes between but that success falls there, and covers as often as the intervals of the
/// surplus, or more often.
/// `surplus` has at least two sizes, in rising order. Throws std::domain_error otherwise.
/// Source: E. C. Fieller, "Some Problems in Interval Estimation" (1954), of inverted tests.
EquivalentSize equivalentSize(const std::vector<Surplus>& surplus);

}  // namespace sim2sim
