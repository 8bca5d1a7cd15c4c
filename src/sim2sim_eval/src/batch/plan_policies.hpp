// SPDX-License-Identifier: BSD-3-Clause
/// Policies of a plan in YAML. Private to the plan of a sweep.
#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <vector>

#include "batch/sweep_plan.hpp"
#include "sim2sim_eval/batch/simulators.hpp"

namespace sim2sim {

/// Reference of a policy in a plan: the simulator of its demonstrations.
inline constexpr const char* kHome = "home";

/// Policies that the `list` names, in its order; those of a pattern in the order of their names. `reference` is that of
/// each policy that has none of its own; none: its home. Throws InvalidInput with line, value and rule.
std::vector<PlannedPolicy> policiesIn(const YAML::Node& list, const std::optional<SimulatorChoice>& reference);

/// Reference that a `policy` has if its reference is its home. Throws InvalidInput, naming the policy, if it has none.
SimulatorChoice homeOfPolicy(const std::string& policy);

}  // namespace sim2sim
