// SPDX-License-Identifier: BSD-3-Clause
#include <nlohmann/json.hpp>
#include <string>

#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_audit/policy_audit.hpp"

namespace sim2sim {
namespace {

constexpr int kDigits = 3;  // of errors [m/s]

std::string numberOf(const Estimate& error) { return pusht::significantText(error.value, kDigits); }

/// "0.084 [0.081, 0.088]"
std::string withInterval(const Estimate& error) {
  const std::string number = numberOf(error);
  return !error.interval ? number
                         : number + " [" + pusht::significantText(error.interval->low, kDigits) + ", " +
                               pusht::significantText(error.interval->high, kDigits) + "]";
}

/// "of energy scores (16 draws) "; empty for a policy that draws no random numbers.
std::string scoreOf(const PolicyAudit& audit) {
  return audit.draws > 1 ? "of energy scores (" + std::to_string(audit.draws) + " draws) " : "";
}

/// A policy that does not look, in words.
std::string blindName(const PolicyAudit& audit) {
  return audit.draws > 1 ? "any recorded action" : "a constant action";
}

std::string verdictLine(const PolicyAudit& audit) {
  const std::string constant = " (" + blindName(audit) + ": " + numberOf(audit.constant) + ")";
  switch (audit.verdict) {
    case PolicyVerdict::kFault:
      return "The policy is asked wrongly: with " + audit.fault() + " the error falls from " + numberOf(audit.error) +
             " to " + numberOf(audit.explanations.front().error) + " m/s" + constant + ".";
    case PolicyVerdict::kUnexplained:
      return "The policy's actions are far from the recorded ones, " + numberOf(audit.error) + " m/s" + constant +
             ", and none of the faults explains it: another task, other demonstrations, or hardly trained.";
    case PolicyVerdict::kNear:
      break;
  }
  return "No fault: the policy's actions are " + numberOf(audit.error) + " m/s from the recorded ones" + constant + ".";
}

nlohmann::ordered_json jsonOf(const Estimate& error) {
  nlohmann::ordered_json json = {{"mean", error.value}, {"interval", nullptr}};
  if (error.interval) {
    json["interval"] = {error.interval->low, error.interval->high};
  }
  return json;
}

}  // namespace

std::string textOf(const PolicyAudit& audit, const std::string& name, const std::string& demonstrations) {
  std::string text = verdictLine(audit) + "\n";
  text += "policy " + name + ", " + demonstrations + ": " + std::to_string(audit.episodes) + " episodes, " +
          std::to_string(audit.steps) + " control steps; errors are means " + scoreOf(audit) + "over " +
          std::to_string(audit.units) + (audit.are_episodes ? " episodes" : " parts of episodes") +
          " that the search did not see, in m/s\n";
  text += "as it is            " + withInterval(audit.error) + "\n";
  text += blindName(audit) + (audit.draws > 1 ? " " : "   ") + withInterval(audit.constant) + "\n";
  text += "best of " + std::to_string(audit.tried) + " faults and pairs of faults:\n";
  for (const Explanation& explanation : audit.explanations) {
    text += std::string(explanation.is_named ? "* " : "  ") + withInterval(explanation.error) + "  with " +
            pusht::joined(explanation.corrections, "; ") + "\n";
  }
  return text;
}

nlohmann::ordered_json toJson(const PolicyAudit& audit) {
  nlohmann::ordered_json json = {{"verdict", nameOf(audit.verdict)},
                                 {"contract_holds", audit.verdict != PolicyVerdict::kFault},
                                 {"episodes", audit.episodes},
                                 {"steps", audit.steps},
                                 {"units", audit.units},
                                 {"unit", audit.are_episodes ? "episode" : "part of an episode"},
                                 {"tried", audit.tried},
                                 {"error", jsonOf(audit.error)},
                                 {audit.draws > 1 ? "any_action" : "constant_action", jsonOf(audit.constant)},
                                 {"explanations", nlohmann::ordered_json::array()}};
  if (audit.draws > 1) {
    json["draws"] = audit.draws;
  }
  for (const Explanation& explanation : audit.explanations) {
    json["explanations"].push_back({{"corrections", explanation.corrections},
                                    {"error", jsonOf(explanation.error)},
                                    {"named", explanation.is_named}});
  }
  return json;
}

}  // namespace sim2sim
