// SPDX-License-Identifier: BSD-3-Clause
/// Audits as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim2sim_audit/audit.hpp"

namespace sim2sim {

/// Audit as JSON: who was audited, whether the contract holds, the keys of the findings, the worst first, and
/// every property with its values, verdict and what it was held against. "none" stands for infinity.
nlohmann::ordered_json toJson(const Audit& audit);

}  // namespace sim2sim
