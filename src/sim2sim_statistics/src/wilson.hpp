// SPDX-License-Identifier: BSD-3-Clause
/// Wilson's interval of a share, for whole and for effective numbers of trials. Private to the statistics.
#pragma once

#include <cmath>

#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// Interval of a `share` of `trials`, which need not be whole, at the quantile `z`; not cut off at 0 and 1.
/// Source: E. B. Wilson, "Probable Inference, the Law of Succession, and Statistical Inference" (JASA, 1927).
inline Interval wilson(double share, double trials, double z) {
  const double shrink = 1.0 + z * z / trials;
  const double center = (share + z * z / (2.0 * trials)) / shrink;
  const double half_width = z / shrink * std::sqrt(share * (1.0 - share) / trials + z * z / (4.0 * trials * trials));
  return {center - half_width, center + half_width};
}

}  // namespace sim2sim
