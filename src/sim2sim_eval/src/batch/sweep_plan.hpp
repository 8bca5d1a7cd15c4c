// SPDX-License-Identifier: BSD-3-Clause
/// Plan of a sweep: the same episodes for many policies and engines, each policy with its reference.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pusht_policy/policy_choice.hpp"
#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_statistics/shapley.hpp"

namespace sim2sim {

/// Policy of a plan, and the reference of its rows.
struct PlannedPolicy {
  std::string policy = pusht::kShippedPolicy;  ///< path or name, as in pusht::PolicyChoice; a file must be there
  std::string group{};                         ///< name of the policies that it stands with; empty: none
  SimulatorChoice reference;
};

/// Row of a sweep: a policy in an engine.
struct PlannedRow {
  std::size_t policy;  ///< in SweepPlan::policies
  SimulatorChoice engine;
};

/// Plan of a sweep: protocol, policies, and the rows.
struct SweepPlan {
  Protocol protocol;
  std::filesystem::path starts;  ///< file for readInitialStates(); empty: spawn seeds
  /// At least one, no two equal; in a plan with several loops once for each
  std::vector<PlannedPolicy> policies;
  bool lists_policies = false;          ///< whether the plan lists policies; otherwise it has just one
  std::vector<PlannedRow> rows;         ///< policy by policy; no two rows are equal
  std::vector<std::string> required{};  ///< of each row, as for --require
  std::optional<OrderSample> sample{};  ///< orders whose combinations the rows are; none: the plan lists its rows
};

/// Reads a plan from YAML. Its keys, all optional:
/// - `policy`; `starts`, a file of initial states as for `compare`; and the options of a run that plans take
///   (RunOptions: `seed`, `episodes`, `horizon`, `floor`, `reanchor`, ...).
/// - `policies` instead of `policy`: a list. Each is a name, a file or a pattern of files (`small-*.ts.pt`, `*.onnx`),
/// or a map
///   with `files` (the same) and, if need be, `group` (a name that stands for all of them in a matrix) and `reference`.
///   Each policy has all rows, except those whose engine is its reference.
/// - `reference`, a simulator: "KIND" or "KIND:NAME=VALUE:NAME=VALUE"; or `home`: for each policy the simulator of its
///   demonstrations, as its provenance names it (pusht::homeOf()). `reference_parameters`, a map of names to values.
///   `scene: FILE` is a short form of MuJoCo's.
/// - `loop`, in both roles: `tracker`, or a map of parameters of the loop to values; or a list of loops, each of which
///   has all rows.
/// - `engine`, a simulator or a list of simulators; each of a list has all rows.
/// - One of three keys for the engine's parameters, needed unless engines or policies alone vary. `grid`: a list of
///   values for each parameter; each combination is a row, and the last parameter varies fastest. `rows`: a list of
///   maps of names to values. `permutations`: `switches` (a list of true/false parameters), `orders` (how many random
///   orders of switching on to draw), `seed`; rows are the combinations along these orders and their reverses.
/// - `require`, a list of what each row must show (results/requirement.hpp).
///
/// Throws InvalidInput with file, line, key, value and rule.
SweepPlan readSweepPlan(const std::filesystem::path& path);

}  // namespace sim2sim
