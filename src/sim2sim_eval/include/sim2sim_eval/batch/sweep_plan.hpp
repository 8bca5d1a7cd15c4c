// SPDX-License-Identifier: BSD-3-Clause
/// What a sweep is to run: the same episodes of one reference for many settings of the engine.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_eval/simulators.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_statistics/shapley.hpp"

namespace sim2sim {

struct SweepPlan {
  Protocol protocol;
  std::string policy = pusht::kShippedPolicy;  ///< as in pusht::PolicyChoice; a file must be there
  std::filesystem::path starts;                ///< file for readInitialStates(); empty: spawn seeds
  SimulatorChoice reference;
  std::vector<SimulatorChoice> rows;    ///< of the engine; each once
  std::optional<OrderSample> sample{};  ///< of which the rows are the combinations; none: the plan names the rows
};

/// From YAML: `policy`, `reference` (a kind), `reference_parameters` (names with values; `scene: FILE` is short for one
/// of MuJoCo), `engine` (a kind, or a list of kinds: each has all rows), `starts` (a file, as of `compare`), `seed`,
/// `first_episode`, `episodes`, `horizon`, `floor`, `reanchor` (a list), `bound_position`,
/// `bound_angle`, and the engine's settings: either `grid` (for each parameter a list of
/// values; every combination is a row, the last one varying fastest), `rows` (a list of settings), or `permutations`
/// (`switches`, a list of true/false parameters; `orders`, how many to draw; `seed`: the combinations along random
/// orders of switching on, and along their reverses); none where the kinds alone vary. Throws InvalidInput with file,
/// line, key, value and rule.
SweepPlan readSweepPlan(const std::filesystem::path& path);

}  // namespace sim2sim
