// SPDX-License-Identifier: BSD-3-Clause
/// JSON of result files: layout of the text, and how figures are written.
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// Text of a JSON file: sorted keys, indent 2, ASCII, a line end.
std::string jsonText(const nlohmann::json& json);

/// `value` rounded by readable(); null unless it is finite.
nlohmann::json readableJson(double value);

/// [low, high], each likewise; null without an interval.
nlohmann::json readableJson(const std::optional<Interval>& interval);

/// `value` as it is; null without one.
template <class Value>
nlohmann::json orNull(const std::optional<Value>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

/// Value of a figure that is not there: null in JSON, empty in CSV.
inline constexpr double kNoFigure = std::numeric_limits<double>::quiet_NaN();

/// A figure, such as an Estimate or a Difference: "value" and "interval", by readableJson().
template <class Figure>
nlohmann::json figureJson(const Figure& figure) {
  return {{"value", readableJson(figure.value)}, {"interval", readableJson(figure.interval)}};
}

/// Adds a figure to the keys of a flat file: NAME_UNIT and NAME_interval_UNIT; without a unit NAME and NAME_interval.
void addFigure(nlohmann::json& keys, const std::string& name, const std::string& unit, double value,
               const std::optional<Interval>& interval);

/// Share of `total` episodes: "episodes", `count`; unless there are none, "share" and "interval". The interval is
/// Wilson's, which holds for independent episodes whose number was chosen before; null unless `has_interval`.
nlohmann::json shareJson(int count, int total, bool has_interval);

}  // namespace sim2sim
