// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/text.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>

#include "pusht_task/numbers.hpp"

namespace sim2sim {

using pusht::fixedText;

namespace {

/// Two digits that count, without an exponent: "1.3", "110", "0.00002"
std::string multipleText(double multiple) {
  constexpr int kDigits = 2;
  constexpr std::size_t kLongest = 400;  // of any double
  const double rounded = pusht::decimal<double>(pusht::significantText(readable(multiple), kDigits)).value_or(multiple);
  std::array<char, kLongest> text{};
  char* const begin = text.data();
  return {begin, std::to_chars(begin, begin + text.size(), rounded, std::chars_format::fixed).ptr};
}

}  // namespace

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

std::string aligned(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], row[i].size());
    }
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += padded(row[i], widths[i] + 2);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text.append(line).append("\n");
  }
  return text;
}

std::string signedText(double value, const std::optional<Interval>& interval, const std::string& unit, int digits) {
  if (std::isnan(value)) {
    return "none";
  }
  return (value > 0.0 ? "+" : "") + fixedText(readable(value), digits) + (unit.empty() ? "" : " " + unit) +
         (interval ? " " + bracketed(*interval, digits) : "");
}

std::string valueText(double value, const std::optional<Interval>& interval, int digits) {
  return fixedText(readable(value), digits) + (interval ? " " + bracketed(*interval, digits) : "");
}

std::string percent(double share, const std::optional<Interval>& interval) {
  return (std::isinf(share) ? "any" : percentNumber(share) + " %") +
         (interval ? " [" + percentNumber(interval->low) + ", " + percentNumber(interval->high) + "]" : "");
}

std::string percentNumber(double share) { return fixedText(100.0 * readable(share), 0); }

std::string pushText(const std::string& reference, const Estimate& missed, const Estimate& turned) {
  return "in the mean episode " + percent(missed.value, missed.interval) + " of those that move " + reference +
         "'s tee miss here" +
         (std::isnan(turned.value)
              ? ""
              : "; of the others " + percent(turned.value, turned.interval) + " move it the other way");
}

std::string markOf(const std::optional<bool>& beats_null) {
  if (!beats_null) {
    return "(?)";
  }
  return *beats_null ? "" : "(!)";
}

std::string timesText(double multiple, const std::optional<Interval>& interval) {
  if (std::isnan(multiple)) {
    return "undefined";
  }
  return multipleText(multiple) + " times" +
         (interval ? " [" + multipleText(interval->low) + ", " + multipleText(interval->high) + "]" : "");
}

std::string probabilityText(double p) {
  constexpr double kLeast = 1e-4;
  constexpr int kDigits = 4;
  return p < kLeast ? "< 0.0001" : fixedText(readable(p), kDigits);
}

std::string csvNumber(double value) { return std::isfinite(value) ? pusht::shortestText(readable(value)) : ""; }

std::string csvFigure(double value, const std::optional<Interval>& interval) {
  return csvNumber(value) + "," + (interval ? csvNumber(interval->low) + "," + csvNumber(interval->high) : ",");
}

std::string csvText(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) {
    return text;
  }
  std::string quoted = "\"";
  for (const char character : text) {
    quoted += character == '"' ? "\"\"" : std::string(1, character);
  }
  return quoted + "\"";
}

}  // namespace sim2sim
