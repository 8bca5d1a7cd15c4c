// SPDX-License-Identifier: BSD-3-Clause
/// Figures as people read them, wherever they are printed.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// `value` to six decimals, as the course has it, or to six digits that count, where that says more: floors are small.
/// Files have figures so, and what is printed is rounded from that: the two agree to the last digit.
double readable(double value);

/// "[0.0700, 0.0934]"
std::string bracketed(const Interval& interval, int digits);

/// `text` filled up with blanks to `width`; one blank at least.
std::string padded(const std::string& text, std::size_t width);

/// "-0.0240 m [-0.0310, -0.0170]": a difference. "none" for NaN.
std::string signedText(double value, const std::optional<Interval>& interval, const std::string& unit, int digits);

/// "31 %"; "any" for infinity.
std::string percent(double share);
/// "31"
std::string percentNumber(double share);

/// Why a figure has no comparison, as words before what would be compared.
inline constexpr const char* kTooFewToCompare = "too few episodes to compare";

/// The mark of a divergence: "(!)" if it is not shown to be less than that of a tee that never moves, "(?)" if there
/// are too few episodes to say, empty if it is less. `beats_null` is empty where there are too few.
std::string markOf(const std::optional<bool>& beats_null);

/// "0.0012", "< 0.0001"
std::string probabilityText(double p);

}  // namespace sim2sim
