// SPDX-License-Identifier: BSD-3-Clause
/// JSON of result files: layout of the text, and how figures are written.
#pragma once

#include <nlohmann/json_fwd.hpp>
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

/// Share of `total` episodes: "episodes", `count`; unless there are none, "share" and "interval". The interval is
/// Wilson's, which holds for independent episodes whose number was chosen before; null unless `has_interval`.
nlohmann::json shareJson(int count, int total, bool has_interval);

}  // namespace sim2sim
