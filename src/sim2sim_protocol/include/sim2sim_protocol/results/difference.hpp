// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sim2sim {

/// The first difference of two JSON values, with both and `link` between them: "/seed is 1, must be 0". Empty if there
/// is none.
std::string firstDifference(const nlohmann::json& one, const nlohmann::json& other, const std::string& link);

}  // namespace sim2sim
