// SPDX-License-Identifier: BSD-3-Clause
/// Attribution as files, and as a table for people.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sim2sim_protocol/results/attribution.hpp"
#include "sim2sim_statistics/cooperative_game.hpp"

namespace sim2sim {

/// Content of attribution.json.
nlohmann::json toJson(const Attribution& attribution);

/// Text of attribution.csv: a row for each gap and switch.
std::string toCsv(const Attribution& attribution);

/// Table for the terminal.
std::string table(const Attribution& attribution);

/// "permutations" in the description of a sweep.
nlohmann::json toJson(const OrderSample& sample);

/// Reads what toJson() wrote. Throws InvalidInput if `json` is anything else.
OrderSample orderSampleFrom(const nlohmann::json& json);

}  // namespace sim2sim
