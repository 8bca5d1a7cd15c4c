// SPDX-License-Identifier: BSD-3-Clause
/// Matrix as files, and as tables for people.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/matrix.hpp"

namespace sim2sim {

/// Content of matrix.json, hypotheses and pairs aside.
nlohmann::json toJson(const Matrix& matrix);

/// Text of matrix.csv: a row for each policy in each simulator.
std::string toCsv(const Matrix& matrix);

/// Tables for the terminal.
std::string table(const Matrix& matrix);

/// Content of "pairs" in matrix.json.
nlohmann::json toJson(const Matrix& matrix, const std::vector<PolicyPair>& pairs);

/// Table of pairs for the terminal; empty without pairs.
std::string table(const Matrix& matrix, const std::vector<PolicyPair>& pairs);

}  // namespace sim2sim
