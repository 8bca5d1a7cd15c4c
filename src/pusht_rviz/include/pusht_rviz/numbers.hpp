// SPDX-License-Identifier: BSD-3-Clause
/// Numbers as the terminal, metrics.json and the report print them, and numbers that people type. Independent of the
/// locale. Whatever cannot be said is kDash.
#pragma once

#include <pusht_msgs/Mean.h>
#include <pusht_msgs/SuccessRate.h>
#include <pusht_msgs/Summary.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <system_error>
#include <type_traits>

namespace pusht_rviz {

inline constexpr const char* kDash = "\u2013";

/// The number that all of `text` is, in decimal digits; none if it is no such number, as "inf", "nan" and 010 are not.
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

/// `value` with `digits` digits after the point, first rounded as in files: to six decimals, or to six digits that
/// count where it is small. So what is shown and what is in metrics.json agree to the last digit.
std::string fixedText(double value, int digits);

/// The shortest text that reads back as `value`: 6, 0.1, 1e-05.
std::string shortText(double value);

/// "30/50  0.600 [0.462, 0.724]"
std::string rateText(const pusht_msgs::SuccessRate& rate);

/// "37 % [21 %, 61 %]"
std::string transferText(const pusht_msgs::Summary& summary);

/// "0.0817 m [0.0692, 0.0964]"; with its mark behind, if it has one.
std::string meanText(const pusht_msgs::Mean& mean);

/// That of `name`, as meanText() has it.
std::string meanText(const pusht_msgs::Summary& summary, const std::string& name);

/// "both solve 6, only reference 24, only engine 5, neither 15"; kDash without episodes.
std::string pairsText(const pusht_msgs::Summary& summary);

/// Mean divergence of the reference from itself, from starts that are moved by the most: position [m] and angle [rad];
/// NaN where a run has no floor.
std::array<double, 2> floorOf(const pusht_msgs::Summary& summary);

/// "45 s left", "3 min left", "2 h 5 min left"; empty for NaN.
std::string timeLeftText(double seconds);

/// "10 Hz", "as fast as possible" for 0.
std::string paceText(double rate);

}  // namespace pusht_rviz
