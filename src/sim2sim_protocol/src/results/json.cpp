// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {

std::string jsonText(const nlohmann::json& json) {
  constexpr int kIndent = 2;
  return json.dump(kIndent, ' ', true, nlohmann::json::error_handler_t::replace) + "\n";
}

nlohmann::json readableJson(double value) {
  return std::isfinite(value) ? nlohmann::json(readable(value)) : nlohmann::json();
}

nlohmann::json readableJson(const std::optional<Interval>& interval) {
  return interval ? nlohmann::json{readableJson(interval->low), readableJson(interval->high)} : nlohmann::json();
}

void addFigure(nlohmann::json& keys, const std::string& name, const std::string& unit, double value,
               const std::optional<Interval>& interval) {
  const std::string of_unit = unit.empty() ? "" : "_" + unit;
  keys[name + of_unit] = readableJson(value);
  keys[name + "_interval" + of_unit] = readableJson(interval);
}

nlohmann::json shareJson(int count, int total, bool has_interval) {
  nlohmann::json share = {{"episodes", count}};
  if (total == 0) {
    return share;
  }
  share["share"] = pusht::roundToMicro(static_cast<double>(count) / total);
  share["interval"] = nullptr;
  if (has_interval) {
    const Interval interval = wilsonInterval(count, total);
    share["interval"] = {pusht::roundToMicro(interval.low), pusht::roundToMicro(interval.high)};
  }
  return share;
}

}  // namespace sim2sim
