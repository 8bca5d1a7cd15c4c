// SPDX-License-Identifier: BSD-3-Clause
/// What the statistics share: how they refuse bad input, and the search for an end of an interval.
#pragma once

#include <algorithm>
#include <array>
#include <boost/math/tools/roots.hpp>
#include <charconv>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace sim2sim {

/// The shortest text that reads back as `value`, marked as a real number: "0.1", "3.0", "nan".
inline std::string shortestText(double value) {
  constexpr std::size_t kLongest = 32;
  std::array<char, kLongest> text{};
  const std::string found(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
  return found.find_first_of(".en") == std::string::npos ? found + ".0" : found;
}

/// Throws std::domain_error: `name value: must be rule`.
template <class Number>
[[noreturn]] void refuse(const std::string& name, Number value, const std::string& rule) {
  const auto text = [&] {
    if constexpr (std::is_integral_v<Number>) {
      return std::to_string(value);
    } else {
      return shortestText(value);
    }
  };
  throw std::domain_error(name + " " + text() + ": must be " + rule);
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
