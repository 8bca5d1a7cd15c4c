// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/numbers.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <system_error>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

using Buffer = std::array<char, 512>;  // the longest double in fixed notation has 309 digits before the point

std::string text(const Buffer& buffer, const std::to_chars_result& result) {
  if (result.ec != std::errc()) {
    throw InternalError("a number does not fit its buffer");
  }
  return std::string(buffer.data(), static_cast<std::size_t>(result.ptr - buffer.data()));
}

}  // namespace

std::string shortestText(double value) {
  Buffer buffer{};
  char* const begin = buffer.data();
  char* const end = begin + buffer.size();
  std::string scientific = text(buffer, std::to_chars(begin, end, value, std::chars_format::scientific));
  if (!std::isfinite(value)) {
    return scientific;
  }
  // Python writes exponents from -4 to 15 out.
  const int exponent = std::stoi(scientific.substr(scientific.find('e') + 1));
  if (exponent < -4 || exponent >= 16) {
    return scientific;
  }
  std::string fixed = text(buffer, std::to_chars(begin, end, value, std::chars_format::fixed));
  return fixed.find('.') == std::string::npos ? fixed + ".0" : fixed;
}

std::string fixedText(double value, int digits) {
  Buffer buffer{};
  return text(buffer,
              std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, digits));
}

std::string significantText(double value, int digits) {
  Buffer buffer{};
  return text(buffer,
              std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, digits));
}

double roundToMicro(double value) {
  constexpr int kDigits = 6;
  const std::string rounded = fixedText(value, kDigits);
  double result = 0.0;
  std::from_chars(rounded.data(), rounded.data() + rounded.size(), result);
  return result;
}

}  // namespace pusht
