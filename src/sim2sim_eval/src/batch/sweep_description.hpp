// SPDX-License-Identifier: BSD-3-Clause
/// Description of a sweep in sweep.json: all that decides it, equal for all its shards.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "batch/sweep_plan.hpp"
#include "sim2sim_eval/batch/loaded_run.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// Describes what runs have in common whatever their engine.
nlohmann::json describeWithoutEngine(const Protocol& protocol, const LoadedRun& loaded);

/// Run that a row of a plan is. `loaded` are the plan's policies, `protocol` the episodes of the row.
RunConfiguration rowConfiguration(const Protocol& protocol, const LoadedRun& loaded, const LoadedSimulator& engine);

/// Describes a plan. `loaded` are its policies, `engines` the records of its rows' engines. If the plan lists policies,
/// "policies" has name, group, reference and content of each, and "rows" the policy's number, engine and its name;
/// otherwise "policy" and "inputs" stand for all rows, and "rows" has engines.
nlohmann::json describe(const SweepPlan& plan, const std::vector<LoadedRun>& loaded,
                        const std::vector<SimulatorRecord>& engines);

/// Provenance of all rows: of the only policy, or of each of "policies".
nlohmann::ordered_json provenanceOf(const SweepPlan& plan, const Protocol& protocol,
                                    const std::vector<LoadedRun>& loaded);

/// Runs that the rows of a described sweep are. Throws json::exception if it is no description, InvalidInput as
/// protocolFrom() or if there are no rows.
std::vector<RunConfiguration> rowsOf(const nlohmann::json& description);

}  // namespace sim2sim
