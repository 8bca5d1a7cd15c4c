// SPDX-License-Identifier: BSD-3-Clause
/// Audit of two simulators, or of one against the task. Work of `rosrun sim2sim_eval audit`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/run_configuration.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Command line of `audit`.
struct AuditOptions {
  std::string reference = kCourseReference;         ///< name of a kind
  std::vector<std::string> reference_parameters{};  ///< "NAME=VALUE", as for chooseSimulator()
  std::string engine = kCourseEngine;               ///< name of a kind
  std::vector<std::string> engine_parameters{};
  std::string against;        ///< "task": the engine alone, against the task's figures; empty: against the reference
  std::uint64_t seed = 0;     ///< moves the scenes of the experiments a little
  int threads = 0;            ///< 0: one for each core that the process may use
  std::filesystem::path out;  ///< JSON file to be written; empty: none
  bool overwrite = false;     ///< replace a file that is there already

  /// Declares the options on a command line.
  void declare(CLI::App& app);
};

/// Prints the audit, writes it, and keeps the verdict of a pair for `compare` (keptVerdict()). Throws ContractError if
/// the contract is broken; InvalidInput for bad options or a file that is there already; as chooseSimulator() and
/// SimulatorKind::load.
void auditSimulators(const AuditOptions& options);

}  // namespace sim2sim
