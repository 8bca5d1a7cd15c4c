// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/difference.hpp"

#include <nlohmann/json.hpp>

namespace sim2sim {

using nlohmann::json;

std::string firstDifference(const json& one, const json& other, const std::string& link) {
  const json difference = json::diff(one, other);
  if (difference.empty()) {
    return "";
  }
  json::json_pointer place(difference[0].at("path").get<std::string>());
  while (!one.contains(place) && !other.contains(place)) {  // the end of a list, which neither has
    place.pop_back();
  }
  const auto text = [&](const json& whole) { return whole.contains(place) ? whole.at(place).dump() : "nothing"; };
  return place.to_string() + " is " + text(one) + link + text(other);
}

}  // namespace sim2sim
