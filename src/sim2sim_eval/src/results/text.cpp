// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/results/text.hpp"

#include <cmath>

#include "pusht_task/numbers.hpp"

namespace sim2sim {

using pusht::fixedText;

std::string bracketed(const Interval& interval, int digits) {
  return "[" + fixedText(interval.low, digits) + ", " + fixedText(interval.high, digits) + "]";
}

std::string padded(const std::string& text, std::size_t width) {
  return text + std::string(width > text.size() ? width - text.size() : 1, ' ');
}

std::string signedText(double value, const std::optional<Interval>& interval, const std::string& unit, int digits) {
  if (std::isnan(value)) {
    return "none";
  }
  return (value > 0.0 ? "+" : "") + fixedText(value, digits) + (unit.empty() ? "" : " " + unit) +
         (interval ? " " + bracketed(*interval, digits) : "");
}

std::string probabilityText(double p) {
  constexpr double kLeast = 1e-4;
  constexpr int kDigits = 4;
  return p < kLeast ? "< 0.0001" : fixedText(p, kDigits);
}

}  // namespace sim2sim
