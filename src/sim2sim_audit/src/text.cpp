// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "pusht_task/clipped.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_audit/audit.hpp"

namespace sim2sim {
namespace {

std::string shown(double value, Property property) {
  return std::isfinite(value) ? pusht::significantText(value, 4) : std::string(nameOfInfinity(property));
}

std::string withUnit(const std::string& text, const char* unit) { return unit[0] == '\0' ? text : text + " " + unit; }

std::size_t countOf(const Audit& audit, PropertyVerdict verdict) {
  return static_cast<std::size_t>(
      std::count_if(audit.comparisons.begin(), audit.comparisons.end(),
                    [&](const Comparison& comparison) { return comparison.verdict == verdict; }));
}

std::string labelOf(const Comparison& finding) {
  const std::string declared = finding.is_declared ? ", declared" : "";
  return (isContract(finding.property) ? "[contract" : "[physics") + declared + "] ";
}

/// Two lines of a finding.
std::string lines(std::size_t rank, const Comparison& finding) {
  const PropertyDescription& description = describe(finding.property);
  constexpr double kMillimeter = 1e-3;
  return std::to_string(rank) + ". " + labelOf(finding) + causeOf(finding) + "\n   " + description.title + ": " +
         shown(*finding.reference, finding.property) + ", here " +
         withUnit(shown(*finding.engine, finding.property), description.unit) + "; same would be within " +
         pusht::significantText(finding.allowed, 4) + " (" + finding.held_against + "). About " +
         pusht::significantText(finding.effect / kMillimeter, 2) + " mm in 0.5 s. Look at: " + description.look_at +
         "\n";
}

/// What cannot be told, by reason.
std::string undecided(const Audit& audit) {
  std::vector<std::string> reasons;  // in order of appearance
  std::map<std::string, std::vector<std::string>> titles;
  for (const Comparison& comparison : audit.comparisons) {
    if (comparison.verdict == PropertyVerdict::kCannotTell) {
      if (titles.count(comparison.reason) == 0) {
        reasons.push_back(comparison.reason);
      }
      titles[comparison.reason].emplace_back(describe(comparison.property).title);
    }
  }
  constexpr std::size_t kMostReasons = 6;
  constexpr std::size_t kLongest = 220;  // bytes
  std::string text;
  for (std::size_t i = 0; i < std::min(kMostReasons, reasons.size()); ++i) {
    text += "cannot tell (" + pusht::clipped(reasons[i], kLongest) +
            "): " + pusht::clipped(pusht::joined(titles[reasons[i]]), kLongest) + "\n";
  }
  if (reasons.size() > kMostReasons) {
    text += "and for " + std::to_string(reasons.size() - kMostReasons) + " other reasons\n";
  }
  return text;
}

}  // namespace

std::string textOf(const Audit& audit) {
  constexpr std::size_t kMostFindings = 12;
  std::string text =
      "audit of " + audit.engine + " against " + audit.reference + ", seed " + std::to_string(audit.seed) + "\n";
  text += std::to_string(countOf(audit, PropertyVerdict::kSame)) + " properties are the same, " +
          std::to_string(countOf(audit, PropertyVerdict::kDiffers)) + " differ, " +
          std::to_string(countOf(audit, PropertyVerdict::kCannotTell)) + " cannot be told\n";
  text += audit.hasContractErrors() ? "The contract is broken: mend that first, then audit again.\n"
                                    : "No error of the contract.\n";
  if (audit.divergence) {
    text += "After 0.5 s of the expert's actions the tees are " + pusht::significantText(1e3 * *audit.divergence, 3) +
            " mm apart; the effects below are estimated.\n";
  }
  const std::vector<Comparison> findings = audit.findings();
  for (std::size_t i = 0; i < std::min(kMostFindings, findings.size()); ++i) {
    text += lines(i + 1, findings[i]);
  }
  if (findings.size() > kMostFindings) {
    text += "and " + std::to_string(findings.size() - kMostFindings) + " more\n";
  }
  return text + undecided(audit);
}

}  // namespace sim2sim
