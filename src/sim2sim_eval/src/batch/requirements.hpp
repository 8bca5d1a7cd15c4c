// SPDX-License-Identifier: BSD-3-Clause
/// Requirements on the command line: a gate for build servers.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/requirement.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace sim2sim {

/// Options --require and --junit.
struct RequirementOptions {
  std::vector<std::string> texts;
  std::filesystem::path junit;  ///< file for JUnit's XML; empty: none

  void declare(CLI::App& app);

  /// The requirements. Throws InvalidInput for one that cannot be read, for --junit without one, and if there is
  /// something at `junit` already, or no folder for it.
  std::vector<Requirement> read() const;
};

/// Answers to all requirements, in their order.
std::vector<RequirementResult> judgeAll(const std::vector<Requirement>& requirements,
                                        const std::function<RequirementResult(const Requirement&)>& judge);

/// Prints the answers, and writes them as JUnit's XML. `command` names the suite of tests.
void report(const std::string& command, const RequirementOptions& options,
            const std::vector<RequirementResult>& results, std::ostream& out);

/// Throws Error unless all requirements are met: with exit code 6 if one is shown not to be, else 7.
void requireAllMet(const std::vector<RequirementResult>& results);

}  // namespace sim2sim
