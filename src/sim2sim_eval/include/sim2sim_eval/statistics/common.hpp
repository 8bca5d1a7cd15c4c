// SPDX-License-Identifier: BSD-3-Clause
/// What the statistics share: how they refuse bad input, and the search for an end of an interval.
#pragma once

#include <algorithm>
#include <boost/math/tools/roots.hpp>
#include <string>
#include <type_traits>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"

namespace sim2sim {

/// Throws pusht::InvalidInput: `name value: must be rule`.
template <class Number>
[[noreturn]] void refuse(const std::string& name, Number value, const std::string& rule) {
  std::string text;
  if constexpr (std::is_integral_v<Number>) {
    text = std::to_string(value);
  } else {
    text = pusht::shortestText(value);
  }
  throw pusht::InvalidInput(name + " " + text + ": must be " + rule);
}

/// How far `holds` holds on the way from `inside`, where it does, to `outside`; all the way if it holds there too.
/// Between the two it must change once. `bits` of the result are right.
template <class Predicate>
double edge(const Predicate& holds, double inside, double outside, int bits = 52) {
  if (inside == outside || holds(outside)) {
    return outside;
  }
  const auto side = [&](double x) { return x == inside || holds(x) ? 1.0 : -1.0; };
  const auto [low, high] = boost::math::tools::bisect(side, std::min(inside, outside), std::max(inside, outside),
                                                      boost::math::tools::eps_tolerance<double>(bits));
  return inside < outside ? low : high;
}

}  // namespace sim2sim
