// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_audit/audit_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace sim2sim {
namespace {

nlohmann::ordered_json numberOf(const std::optional<double>& value, const char* infinite = "none") {
  if (!value) {
    return nullptr;
  }
  return std::isfinite(*value) ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(infinite);
}

nlohmann::ordered_json toJson(const Comparison& comparison) {
  const PropertyDescription& description = describe(comparison.property);
  nlohmann::ordered_json json = {{"property", description.key},
                                 {"title", description.title},
                                 {"unit", description.unit},
                                 {"area", nameOf(description.area)},
                                 {"contract", isContract(comparison.property)},
                                 {"declared", comparison.is_declared},
                                 {"verdict", nameOf(comparison.verdict)},
                                 {"reference", numberOf(comparison.reference, nameOfInfinity(comparison.property))},
                                 {"engine", numberOf(comparison.engine, nameOfInfinity(comparison.property))}};
  if (comparison.verdict == PropertyVerdict::kCannotTell) {
    json["reason"] = comparison.reason;
    return json;
  }
  json["difference"] = numberOf(*comparison.engine == *comparison.reference ? 0.0 : comparison.difference());
  json["allowed"] = comparison.allowed;
  json["held_against"] = comparison.held_against;
  if (comparison.verdict == PropertyVerdict::kDiffers) {
    json["estimated_effect_m"] = comparison.effect;
    json["cause"] = causeOf(comparison);
    json["look_at"] = description.look_at;
  }
  return json;
}

}  // namespace

nlohmann::ordered_json toJson(const Audit& audit) {
  nlohmann::ordered_json json = {{"reference", audit.reference},
                                 {"engine", audit.engine},
                                 {"variants", audit.variants},
                                 {"seed", audit.seed},
                                 {"contract_holds", !audit.hasContractErrors()},
                                 {"divergence_after_5_steps_m", numberOf(audit.divergence)},
                                 {"findings", nlohmann::ordered_json::array()},
                                 {"properties", nlohmann::ordered_json::array()}};
  for (const Comparison& finding : audit.findings()) {
    json["findings"].push_back(describe(finding.property).key);
  }
  for (const Comparison& comparison : audit.comparisons) {
    json["properties"].push_back(toJson(comparison));
  }
  return json;
}

}  // namespace sim2sim
