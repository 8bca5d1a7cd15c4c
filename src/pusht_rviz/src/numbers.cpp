// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/numbers.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

namespace pusht_rviz {
namespace {

using Buffer = std::array<char, 512>;  // the longest double in fixed notation has 309 digits before the point

template <class... Format>
std::string printed(double value, Format... format) {
  Buffer buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, format...).ptr;
  return {buffer.data(), static_cast<std::size_t>(end - buffer.data())};
}

double read(const std::string& text) {
  double value = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// As files have it.
double readable(double value) {
  constexpr double kSmall = 1e-3;
  constexpr int kDigits = 6;
  const bool small = value != 0.0 && std::abs(value) < kSmall;
  return read(printed(value, small ? std::chars_format::general : std::chars_format::fixed, kDigits));
}

std::string bracketed(const std::string& low, const std::string& high) { return "[" + low + ", " + high + "]"; }

/// A transfer, with as many digits as it takes to stand on its side of each bound of the headline's words.
std::string percent(double share) {
  if (std::isinf(share)) {
    return "any";
  }
  constexpr std::array kBounds = {0.5, 0.9, 1.1};
  constexpr int kMostDigits = 4;
  const double exact = readable(share);
  std::string text;
  for (int digits = 0; digits <= kMostDigits; ++digits) {
    text = fixedText(100.0 * exact, digits);
    const double shown = read(text) / 100.0;
    if (std::all_of(kBounds.begin(), kBounds.end(), [&](double bound) {
          return (shown < bound) == (exact < bound) && (shown > bound) == (exact > bound);
        })) {
      break;
    }
  }
  return text + " %";
}

}  // namespace

std::string fixedText(double value, int digits) {
  return std::isfinite(value) ? printed(readable(value), std::chars_format::fixed, digits) : kDash;
}

std::string shortText(double value) { return printed(value); }

std::string rateText(const pusht_msgs::SuccessRate& rate) {
  constexpr int kDigits = 3;
  if (rate.trials == 0 || std::isnan(rate.rate)) {
    return kDash;
  }
  const std::string count = std::to_string(rate.successes) + "/" + std::to_string(rate.trials);
  const std::string value = count + "  " + fixedText(rate.rate, kDigits);
  return std::isnan(rate.low) ? value
                              : value + " " + bracketed(fixedText(rate.low, kDigits), fixedText(rate.high, kDigits));
}

std::string transferText(const pusht_msgs::Summary& summary) {
  if (summary.reference.trials == 0 || std::isnan(summary.transfer)) {
    return kDash;
  }
  const std::string value = percent(summary.transfer);
  return std::isnan(summary.transfer_low)
             ? value
             : value + " " + bracketed(percent(summary.transfer_low), percent(summary.transfer_high));
}

std::string meanText(const pusht_msgs::Mean& mean) {
  constexpr int kDigits = 4;
  if (std::isnan(mean.value)) {
    return kDash;
  }
  std::string text = fixedText(mean.value, kDigits) + " " + mean.unit;
  if (!std::isnan(mean.low)) {
    text += " " + bracketed(fixedText(mean.low, kDigits), fixedText(mean.high, kDigits));
  }
  return mean.mark.empty() ? text : text + " " + mean.mark;
}

std::string meanText(const pusht_msgs::Summary& summary, const std::string& name) {
  const auto mean = std::find_if(summary.means.begin(), summary.means.end(),
                                 [&](const pusht_msgs::Mean& candidate) { return candidate.name == name; });
  return mean == summary.means.end() ? kDash : meanText(*mean);
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
  for (const pusht_msgs::Mean& mean : summary.means) {  // the widest floor is the last one
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

std::string paceText(double rate) { return rate > 0.0 ? shortText(rate) + " Hz" : "as fast as possible"; }

}  // namespace pusht_rviz
