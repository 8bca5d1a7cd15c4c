// SPDX-License-Identifier: BSD-3-Clause
/// Plan of a sweep: the same episodes of one reference for many parameter values of the engine.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_statistics/shapley.hpp"

namespace sim2sim {

/// Plan of a sweep: protocol, policy, reference, and the rows.
struct SweepPlan {
  Protocol protocol;
  std::string policy = pusht::kShippedPolicy;  ///< path or name, as in pusht::PolicyChoice; a file must be there
  std::filesystem::path starts;                ///< file for readInitialStates(); empty: spawn seeds
  SimulatorChoice reference;
  std::vector<SimulatorChoice> rows;    ///< engine and its parameters, by row; no two rows are equal
  std::optional<OrderSample> sample{};  ///< orders whose combinations the rows are; none: the plan lists its rows
};

/// Reads a plan from YAML. Its keys, all optional:
/// - `policy`; `starts`, a file of initial states as for `compare`; and the options of a run that plans take
///   (RunOptions: `seed`, `episodes`, `horizon`, `floor`, `reanchor`, ...).
/// - `reference`, a kind; `reference_parameters`, a map of names to values. `scene: FILE` is a short form of MuJoCo's.
/// - `engine`, a kind or a list of kinds; each kind of a list has all rows.
/// - One of three keys for the engine's parameters, needed unless kinds alone vary. `grid`: a list of values for each
///   parameter; each combination is a row, and the last parameter varies fastest. `rows`: a list of maps of names to
///   values. `permutations`: `switches` (a list of true/false parameters), `orders` (how many random orders of
///   switching on to draw), `seed`; rows are the combinations along these orders and their reverses.
///
/// Throws InvalidInput with file, line, key, value and rule.
SweepPlan readSweepPlan(const std::filesystem::path& path);

}  // namespace sim2sim
