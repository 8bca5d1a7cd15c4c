// SPDX-License-Identifier: BSD-3-Clause
/// Equivalents as files, and as a table for people.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sim2sim_protocol/results/equivalent.hpp"

namespace sim2sim {

/// Content of equivalent.json. An error beyond the largest that was tried is null.
nlohmann::json toJson(const Equivalents& equivalents);

/// Text of equivalent.csv: a row for each engine, parameter and size, with the success there.
std::string toCsv(const Equivalents& equivalents);

/// Table for the terminal.
std::string table(const Equivalents& equivalents);

}  // namespace sim2sim
