// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <boost/math/tools/roots.hpp>

#include "sim2sim_statistics/common.hpp"

namespace sim2sim {

double edge(const std::function<bool(double)>& holds, double inside, double outside, int bits) {
  if (inside == outside || holds(outside)) {
    return outside;
  }
  const auto side = [&](double x) { return x == inside || holds(x) ? 1.0 : -1.0; };
  const auto [low, high] = boost::math::tools::bisect(side, std::min(inside, outside), std::max(inside, outside),
                                                      boost::math::tools::eps_tolerance<double>(bits));
  return inside < outside ? low : high;
}

}  // namespace sim2sim
