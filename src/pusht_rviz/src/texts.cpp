// SPDX-License-Identifier: BSD-3-Clause
#include "texts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "pusht_task/numbers.hpp"

namespace pusht_rviz {

std::string orDash(const std::string& text) { return text.empty() ? kDash : text; }

std::string meanText(const pusht_msgs::Summary& summary, const std::string& name) {
  const auto mean = std::find_if(summary.means.begin(), summary.means.end(),
                                 [&](const pusht_msgs::Mean& candidate) { return candidate.name == name; });
  return mean == summary.means.end() ? kDash : orDash(mean->text);
}

std::string pairsText(const pusht_msgs::Summary& summary) {
  if (summary.episodes_finished == 0) {
    return kDash;
  }
  return "both solve " + std::to_string(summary.both_succeed) + ", only reference " +
         std::to_string(summary.only_reference_succeeds) + ", only engine " +
         std::to_string(summary.only_engine_succeeds) + ", neither " + std::to_string(summary.neither_succeeds);
}

std::array<double, 2> floorOf(const pusht_msgs::Summary& summary) {
  std::array<double, 2> floor = {std::nan(""), std::nan("")};
  for (const pusht_msgs::Mean& mean : summary.means) {  // that of the largest change comes last
    const bool of_floor = mean.name.rfind("floor_", 0) == 0;
    const auto ends = [&](const std::string& end) {
      return mean.name.size() > end.size() && mean.name.compare(mean.name.size() - end.size(), end.size(), end) == 0;
    };
    if (of_floor && ends("_mean_position_divergence")) {
      floor[0] = mean.value;
    } else if (of_floor && ends("_mean_angle_divergence")) {
      floor[1] = mean.value;
    }
  }
  return floor;
}

std::string timeLeftText(double seconds) {
  constexpr double kMinute = 60.0;
  constexpr std::int64_t kMinutesInHour = 60;
  if (!std::isfinite(seconds)) {
    return "";
  }
  if (seconds <= kMinute - 1.0) {
    return std::to_string(static_cast<int>(std::ceil(seconds))) + " s left";
  }
  const auto minutes = static_cast<std::int64_t>(std::ceil(seconds / kMinute));
  const std::string rest = std::to_string(minutes % kMinutesInHour) + " min left";
  return minutes < kMinutesInHour ? rest : std::to_string(minutes / kMinutesInHour) + " h " + rest;
}

std::string paceText(double rate) {
  constexpr int kDigits = 6;
  return rate > 0.0 ? pusht::significantText(rate, kDigits) + " Hz" : "as fast as possible";
}

}  // namespace pusht_rviz
