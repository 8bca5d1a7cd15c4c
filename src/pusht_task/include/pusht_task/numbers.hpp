// SPDX-License-Identifier: BSD-3-Clause
/// Numbers as text and from text, and rounded, the way Python does it; independent of the locale.
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <system_error>
#include <type_traits>

namespace pusht {

/// The number that all of `text` is, in decimal digits; none if it is no such number, as "inf" and "nan" are not. 010
/// is none either: elsewhere that is 8.
template <class Number>
std::optional<Number> decimal(const std::string& text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  const std::size_t first = text.empty() || text.front() != '-' ? 0 : 1;
  const bool padded = text.size() > first + 1 && text[first] == '0' && text[first + 1] >= '0' && text[first + 1] <= '9';
  if (read.ec != std::errc() || read.ptr != end || padded) {
    return std::nullopt;
  }
  if constexpr (std::is_floating_point_v<Number>) {
    if (!std::isfinite(number)) {
      return std::nullopt;
    }
  }
  return number;
}

/// The shortest text that reads back as `value`, as Python's repr() writes it: 4.0, 0.1, 1e-05, 1e+16.
std::string shortestText(double value);

/// `value` with `digits` digits after the point, correctly rounded: 0.082000.
std::string fixedText(double value, int digits);

/// `value` with the first `digits` digits that count, as C's %g writes it: 0.0123, 1.23e-09.
std::string significantText(double value, int digits);

/// The double nearest to `value` rounded to six decimals, as Python's round(value, 6).
double roundToMicro(double value);

}  // namespace pusht
