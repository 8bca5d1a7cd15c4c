// SPDX-License-Identifier: BSD-3-Clause
/// Policies of a plan, loaded.
#pragma once

#include <string>
#include <vector>

#include "batch/sweep_plan.hpp"
#include "sim2sim_eval/batch/loaded_run.hpp"

namespace sim2sim {

/// Loads all policies of a plan, each with its reference. Of several, one that is refused is taken out of the plan, and
/// named in `refused`; not of a shard, as a merged sweep has all rows. Throws, the first of them if all are refused, as
/// LoadedRun.
std::vector<LoadedRun> loadAll(SweepPlan& plan, bool is_shard, std::vector<std::string>& refused);

}  // namespace sim2sim
