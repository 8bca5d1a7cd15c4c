// SPDX-License-Identifier: BSD-3-Clause
#include "batch/loaded_plan.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <iostream>

#include "pusht_task/error.hpp"

namespace sim2sim {
namespace {

/// Takes a policy and its rows out of a plan.
void remove(SweepPlan& plan, std::size_t policy) {
  plan.policies.erase(plan.policies.begin() + static_cast<std::ptrdiff_t>(policy));
  plan.rows.erase(std::remove_if(plan.rows.begin(), plan.rows.end(),
                                 [policy](const PlannedRow& row) { return row.policy == policy; }),
                  plan.rows.end());
  for (PlannedRow& row : plan.rows) {
    row.policy -= row.policy > policy ? 1 : 0;
  }
}

LoadedRun load(const SweepPlan& plan, std::size_t policy) {
  std::vector<SimulatorChoice> engines;
  for (const PlannedRow& row : plan.rows) {
    if (row.policy == policy) {
      engines.push_back(row.engine);
    }
  }
  const PlannedPolicy& planned = plan.policies[policy];
  return {pusht::PolicyChoice{planned.policy, true, plan.protocol.seed, false, plan.protocol.runTask()},
          planned.reference, engines, plan.protocol};
}

}  // namespace

std::vector<LoadedRun> loadAll(SweepPlan& plan, bool is_shard, std::vector<std::string>& refused) {
  std::vector<LoadedRun> loaded;
  std::exception_ptr first;
  while (loaded.size() < plan.policies.size()) {
    try {
      loaded.push_back(load(plan, loaded.size()));
    } catch (const pusht::Error& error) {
      const bool is_of_the_policy =
          error.exitCode() == pusht::ExitCode::kInvalidInput || error.exitCode() == pusht::ExitCode::kBadDependency;
      if (!is_of_the_policy || is_shard) {
        throw;
      }
      first = first ? first : std::current_exception();
      refused.emplace_back(error.what());
      remove(plan, loaded.size());
    }
  }
  if (loaded.empty()) {
    std::rethrow_exception(first);
  }
  for (const std::string& why : refused) {
    std::cerr << "sweep: left out: " << why << std::endl;
  }
  return loaded;
}

}  // namespace sim2sim
