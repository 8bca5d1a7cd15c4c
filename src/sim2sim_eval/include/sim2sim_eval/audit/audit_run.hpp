// SPDX-License-Identifier: BSD-3-Clause
/// Audits as the command `audit` and the node `audit` carry them out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "pusht_task/simulator_kind.hpp"
#include "sim2sim_audit/audit.hpp"

namespace sim2sim {

/// Word for the task in place of a reference.
constexpr const char* kAgainstTask = "task";

/// Worlds of an audit, and how it is carried out.
struct AuditRun {
  std::optional<AuditedWorld> reference;  ///< none: the task's own figures
  AuditedWorld engine;
  std::vector<AuditedWorld> variants{};  ///< model variants of the reference
  std::uint64_t seed = 0;
  int threads = 1;
};

/// Model variants of a reference, as its kind lists them. Throws what SimulatorKind::load throws.
std::vector<AuditedWorld> variantsOf(const pusht::SimulatorKind& kind, const pusht::ParameterSet& parameters);

/// Carries the audit out. Once the process is interrupted no world is asked any more. Throws RuntimeFault then.
Audit carryOut(const AuditRun& run);

/// Prints the audit, and writes it into the file `out`, unless that is empty. Throws ContractError if the contract is
/// broken.
void report(const Audit& audit, const std::filesystem::path& out);

}  // namespace sim2sim
