// SPDX-License-Identifier: BSD-3-Clause
/// Tested hypotheses in files, and as a table for people.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/hypotheses.hpp"

namespace sim2sim {

/// Value of the key "hypotheses" in matrix.json: a list.
nlohmann::json toJson(const std::vector<HypothesisResult>& hypotheses);

/// Table for the terminal; empty without hypotheses.
std::string table(const std::vector<HypothesisResult>& hypotheses);

}  // namespace sim2sim
