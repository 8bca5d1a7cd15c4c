// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/json_text.hpp"

#include <nlohmann/json.hpp>

namespace pusht {
namespace {

constexpr int kDeepest = 100;  // levels; no file of the suite has more than 12

struct TooDeep {};

template <class Json>
Json parsed(const std::string& text) {
  const auto check = [](int depth, typename Json::parse_event_t event, const Json& /*value*/) {
    const bool opens = event == Json::parse_event_t::object_start || event == Json::parse_event_t::array_start;
    if (opens && depth >= kDeepest) {
      throw TooDeep();
    }
    return true;
  };
  try {
    return Json::parse(text, check, false);
  } catch (const TooDeep&) {
    return Json(Json::value_t::discarded);
  }
}

}  // namespace

nlohmann::json parseJson(const std::string& text) { return parsed<nlohmann::json>(text); }

nlohmann::ordered_json parseOrderedJson(const std::string& text) { return parsed<nlohmann::ordered_json>(text); }

}  // namespace pusht
