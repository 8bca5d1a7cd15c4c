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

/// Number in a message: digits; a real number shortest, and marked as one: "0.1", "3.0", "nan".
template <class Number>
std::string refusedText(Number value) {
  constexpr std::size_t kLongest = 32;
  std::array<char, kLongest> text{};
  const std::string found(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
  return std::is_integral_v<Number> || found.find_first_of(".en") != std::string::npos ? found : found + ".0";
}

/// Throws std::domain_error with the message "NAME VALUE: must be RULE".
template <class Number>
[[noreturn]] void refuse(const std::string& name, Number value, const std::string& rule) {
  throw std::domain_error(name + " " + refusedText(value) + ": must be " + rule);
}

/// Likewise, with a rule that ends in a number: "NAME VALUE: must be RULE BOUND".
[[noreturn]] inline void refuse(const std::string& name, double value, const std::string& rule, double bound) {
  refuse(name, value, rule + " " + refusedText(bound));
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
