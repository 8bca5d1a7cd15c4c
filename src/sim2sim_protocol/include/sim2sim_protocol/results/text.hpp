// SPDX-License-Identifier: BSD-3-Clause
/// Figures as text for people.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// Rounds `value` to six decimals, as the course does, or to six significant digits if that is more precise, because
/// floors are small. Files have figures like this, and printed figures are rounded from these, so that the two agree.
double readable(double value);

/// Interval as "[0.0700, 0.0934]".
std::string bracketed(const Interval& interval, int digits);

/// `text` with blanks behind it up to `width`, at least one blank.
std::string padded(const std::string& text, std::size_t width);

/// Lines of a table whose columns are as wide as their widest cell. Rows have the same length; there is one.
std::string aligned(const std::vector<std::vector<std::string>>& rows);

/// Difference as "-0.0240 m [-0.0310, -0.0170]"; "none" for NaN.
std::string signedText(double value, const std::optional<Interval>& interval, const std::string& unit, int digits);

/// Value as "0.220", with an interval as "0.220 [0.128, 0.352]".
std::string valueText(double value, const std::optional<Interval>& interval, int digits);

/// Share as "31 %", with an interval as "31 % [23, 40]"; "any" for infinity.
std::string percent(double share, const std::optional<Interval>& interval = std::nullopt);
/// Share in percent as "31".
std::string percentNumber(double share);

/// Pushes as "in the mean episode 18 % [14, 23] of those that move MuJoCo's tee miss here; of the others 43 % [37, 49]
/// move it the other way".
/// `turned` is a share of those that are not missed; NaN if all are.
std::string pushText(const std::string& reference, const Estimate& missed, const Estimate& turned);

/// Reason why a figure has no comparison, before the words for what would be compared.
inline constexpr const char* kTooFewToCompare = "too few episodes to compare";

/// Mark of a divergence: "(!)" if it is not shown to be less than that of a tee that never moves, empty if it is, "(?)"
/// if there are too few episodes to say (`beats_null` is empty).
std::string markOf(const std::optional<bool>& beats_null);

/// Ratio as "1.3 times" or "110 times", with an interval as "68 times [9.3, 420]"; "undefined" for NaN.
std::string timesText(double multiple, const std::optional<Interval>& interval);

/// Text as a cell of CSV, quoted if need be. Source: RFC 4180.
std::string csvText(const std::string& text);

/// Number as a cell of CSV, rounded by readable(); empty unless it is finite.
std::string csvNumber(double value);

/// Figure as three cells of CSV: value and both ends of its interval, which are empty without one.
std::string csvFigure(double value, const std::optional<Interval>& interval);

/// p-value as "0.0012" or "< 0.0001".
std::string probabilityText(double p);

}  // namespace sim2sim
