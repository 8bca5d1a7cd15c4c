// SPDX-License-Identifier: BSD-3-Clause
/// What `compare` knows of the audit of its two simulators.
#pragma once

#include <string>

#include "sim2sim_eval/batch/simulators.hpp"
#include "sim2sim_protocol/results/audit_files.hpp"

namespace sim2sim {

/// Folder in which `audit` keeps its verdicts: below the current one, beside the results that have no --out.
inline constexpr const char* kAuditsFolder = "results/audits";

/// Verdict of the last audit of a pair, under both simulators with all parameters and the code that decides what they
/// do and what an audit finds.
KeptVerdict keptVerdict(const LoadedSimulator& reference, const LoadedSimulator& engine);

/// Command that audits a pair, for a shell.
std::string auditCommand(const LoadedSimulator& reference, const LoadedSimulator& engine);

/// Line of `compare`: the pair was never audited, or its audit has found errors of the contract. Empty if it keeps the
/// contract. Throws as KeptVerdict::find().
std::string auditNote(const LoadedSimulator& reference, const LoadedSimulator& engine);

}  // namespace sim2sim
