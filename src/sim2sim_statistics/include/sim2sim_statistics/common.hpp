// SPDX-License-Identifier: BSD-3-Clause
/// Shared parts of the statistics: refusal of bad input, sums, and the search for an end of an interval.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace sim2sim {

/// Shortest text that reads back as `value`, marked as a real number: "0.1", "3.0", "nan".
inline std::string shortestText(double value) {
  constexpr std::size_t kLongest = 32;
  std::array<char, kLongest> text{};
  const std::string found(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
  return found.find_first_of(".en") == std::string::npos ? found + ".0" : found;
}

/// Throws std::domain_error with the message "NAME VALUE: must be RULE".
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

/// Sum of the values, in their order.
inline double sumOf(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// Mean of the values, summed in their order; NaN without any.
inline double averageOf(const std::vector<double>& values) {
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : sumOf(values) / static_cast<double>(values.size());
}

/// Last point at which `holds` is true on the way from `inside`, where it is, to `outside`; `outside` itself if it is
/// true there too. It must change once in between. The result has `bits` correct bits. Source: bisection.
double edge(const std::function<bool(double)>& holds, double inside, double outside, int bits = 52);

}  // namespace sim2sim
