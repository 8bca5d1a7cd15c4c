// SPDX-License-Identifier: BSD-3-Clause
/// Texts that the panel shows. Figures come as texts in the messages, in the digits of the terminal. Independent of the
/// locale.
#pragma once

#include <pusht_msgs/Summary.h>

#include <array>
#include <string>

namespace pusht_rviz {

inline constexpr const char* kDash = "\u2013";  ///< in place of a figure that there is none of

/// `text`, or kDash if it is empty.
std::string orDash(const std::string& text);

/// Text of the mean `name`, "0.0817 m [0.0692, 0.0964] (!)"; kDash if there is none.
std::string meanText(const pusht_msgs::Summary& summary, const std::string& name);

/// "both solve 6, only reference 24, only engine 5, neither 15"; kDash without episodes.
std::string pairsText(const pusht_msgs::Summary& summary);

/// Mean divergence of the reference from itself, position [m] and angle [rad], after the largest change of the initial
/// state; NaN for a run without floor.
std::array<double, 2> floorOf(const pusht_msgs::Summary& summary);

/// "45 s left", "3 min left", "2 h 5 min left", rounded up; empty for NaN.
std::string timeLeftText(double seconds);

/// "10 Hz", "as fast as possible" for 0.
std::string paceText(double rate);

}  // namespace pusht_rviz
