// SPDX-License-Identifier: BSD-3-Clause
/// Agreement of simulators as a file, and as matrices for people.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sim2sim_protocol/results/agreement.hpp"

namespace sim2sim {

/// Content of the file of `agreement`, in meters and radians. Simulators are in the order of the list; entry (i, j) of
/// `distances` is the distance of j from i.
nlohmann::json toJson(const Agreement& agreement);

/// Matrices for the terminal, in millimeters and milliradians: one for each kind of replay and each divergence.
std::string table(const Agreement& agreement);

}  // namespace sim2sim
