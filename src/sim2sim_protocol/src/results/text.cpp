// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/text.hpp"

#include <charconv>
#include <cmath>

#include "pusht_task/numbers.hpp"

namespace sim2sim {

using pusht::fixedText;

double readable(double value) {
  constexpr double kSmall = 1e-3;
  constexpr int kDigits = 6;
  if (value == 0.0 || std::abs(value) >= kSmall) {
    return pusht::roundToMicro(value);
  }
  const std::string text = pusht::significantText(value, kDigits);
  double rounded = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  return rounded;
}

std::string bracketed(const Interval& interval, int digits) {
  return "[" + fixedText(readable(interval.low), digits) + ", " + fixedText(readable(interval.high), digits) + "]";
}

std::string padded(const std::string& text, std::size_t width) {
  return text + std::string(width > text.size() ? width - text.size() : 1, ' ');
}

std::string signedText(double value, const std::optional<Interval>& interval, const std::string& unit, int digits) {
  if (std::isnan(value)) {
    return "none";
  }
  return (value > 0.0 ? "+" : "") + fixedText(readable(value), digits) + (unit.empty() ? "" : " " + unit) +
         (interval ? " " + bracketed(*interval, digits) : "");
}

std::string percent(double share) { return std::isinf(share) ? "any" : percentNumber(share) + " %"; }

std::string percentNumber(double share) { return fixedText(100.0 * readable(share), 0); }

std::string markOf(const std::optional<bool>& beats_null) {
  if (!beats_null) {
    return "(?)";
  }
  return *beats_null ? "" : "(!)";
}

std::string probabilityText(double p) {
  constexpr double kLeast = 1e-4;
  constexpr int kDigits = 4;
  return p < kLeast ? "< 0.0001" : fixedText(readable(p), kDigits);
}

}  // namespace sim2sim
