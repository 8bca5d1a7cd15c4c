// SPDX-License-Identifier: BSD-3-Clause
/// Audits as files: audit.json, and the verdicts that are kept for later runs.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// Text of audit.json: the audit, with the number of the format, and with both simulators as metrics.json names them.
/// An audit against the task has no reference.
std::string auditText(const nlohmann::ordered_json& audit, const std::optional<SimulatorRecord>& reference,
                      const SimulatorRecord& engine);

/// Verdict of the last audit of a pair of simulators, in a file of its own: FOLDER/HASH.json, where HASH is keptName()
/// of the key. Threads and processes may share a folder.
class KeptVerdict {
 public:
  /// `key` is all that the verdict depends on: both simulators, and the code that decides what they do.
  KeptVerdict(const std::filesystem::path& folder, nlohmann::json key);

  /// Errors of the contract that the audit has found, by title, the worst first. None if the pair was never audited.
  /// Throws BadDependency with the file if that is damaged or belongs to another pair.
  std::optional<std::vector<std::string>> find() const;

  /// Keeps a verdict, in place of an earlier one. Throws RuntimeFault if it cannot be written.
  void keep(const std::vector<std::string>& contract_errors) const;

 private:
  nlohmann::json key_;
  std::filesystem::path file_;
};

}  // namespace sim2sim
