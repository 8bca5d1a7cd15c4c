// SPDX-License-Identifier: BSD-3-Clause
/// Audits as the command `audit` and the node `audit` carry them out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/simulator_kind.hpp"
#include "sim2sim_audit/audit.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// Word for the task in place of a reference.
constexpr const char* kAgainstTask = "task";

/// Simulator of an audit, in this process or a node.
struct AuditedSimulator {
  SimulatorRecord record;
  WorldFactory make;
  std::vector<std::string> departures{};  ///< those of its kind
};

/// Simulators of an audit, and how it is carried out.
struct AuditRun {
  std::optional<AuditedSimulator> reference;  ///< none: the task's own figures
  AuditedSimulator engine;
  std::vector<AuditedWorld> variants{};  ///< model variants of the reference
  std::uint64_t seed = 0;
  int threads = 1;
  std::reference_wrapper<const pusht::Task> task = pusht::fullCircle();
};

/// Model variants of a reference, as its kind lists them. Throws what SimulatorKind::load throws.
std::vector<AuditedWorld> variantsOf(const pusht::SimulatorKind& kind, const pusht::ParameterSet& parameters,
                                     const pusht::Task& task = pusht::fullCircle());

/// Throws InvalidInput for a task for which the scenes of the experiments are not made.
void requireFits(const pusht::Task& task);

/// Carries the audit out. Once the process is interrupted no world is asked any more. Throws RuntimeFault then.
Audit carryOut(const AuditRun& run);

/// Prints the audit, and writes it into the file `out`, unless that is empty. Throws RuntimeFault if there is such a
/// file by now, unless `overwrite`.
void report(const AuditRun& run, const Audit& audit, const std::filesystem::path& out, bool overwrite);

/// Throws ContractError with the worst finding if the contract is broken.
void requireContract(const Audit& audit);

}  // namespace sim2sim
