// SPDX-License-Identifier: BSD-3-Clause
/// Policies of a plan in YAML. Private to the plan of a sweep.
#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <vector>

#include "batch/sweep_plan.hpp"
#include "sim2sim_eval/batch/simulators.hpp"

namespace sim2sim {

/// Value of `reference` in a plan: the simulator of each policy's own demonstrations.
inline constexpr const char* kHome = "home";

/// Policies of a plan, in its order; those of a pattern in the order of their names. `reference` is that of each policy
/// that has none of its own; none: its home, which is the simulator of its demonstrations. Throws InvalidInput with
/// line, value and rule.
std::vector<PlannedPolicy> plannedPolicies(const YAML::Node& root, const std::optional<SimulatorChoice>& reference);

}  // namespace sim2sim
