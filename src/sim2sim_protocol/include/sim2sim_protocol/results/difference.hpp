// SPDX-License-Identifier: BSD-3-Clause
/// Difference of two JSON values, for messages.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sim2sim {

/// First difference of two JSON values, with `link` between them: "/seed is 1, must be 0". Empty if they are equal.
std::string firstDifference(const nlohmann::json& one, const nlohmann::json& other, const std::string& link);

}  // namespace sim2sim
