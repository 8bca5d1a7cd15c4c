// SPDX-License-Identifier: BSD-3-Clause
// Cells and lines of tables that other outputs have, too.
#include <cmath>
#include <optional>
#include <string>

#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/headline.hpp"
#include "sim2sim_protocol/results/table.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {

std::string transferText(const RunConfiguration& configuration, const Outcomes& outcomes) {
  if (!outcomes.transfer) {
    return "undefined: the reference never succeeds";
  }
  const auto text = [&](double share) {
    return std::isinf(share) ? "any" : transferNumber(configuration, share) + " %";
  };
  const std::optional<Interval> interval = transferInterval(configuration.protocol, outcomes);
  return text(*outcomes.transfer) + (interval ? " [" + text(interval->low) + ", " + text(interval->high) + "]" : "");
}

std::string shareText(const SuccessRate& rate) {
  constexpr int kDigits = 3;
  return valueText(rate.rate, rate.interval, kDigits);
}

std::string cell(const SuccessRate& rate) { return std::to_string(rate.successes) + "  " + shareText(rate); }

std::string cell(const Estimate& estimate, const std::string& unit) {
  constexpr int kDigits = 4;
  const std::string value = pusht::fixedText(readable(estimate.value), kDigits) + " " + unit;
  return estimate.interval ? value + " " + bracketed(*estimate.interval, kDigits) : value;
}

std::string decisionText(const TransferBet& bet, double share) {
  constexpr int kDigits = 6;
  const std::string success = pusht::significantText(100.0 * share, kDigits) + " % of the reference's success";
  if (bet.verdict() == Verdict::kUndecided) {
    return "not decided after " + std::to_string(bet.counts().pairs()) + " episodes: does the engine keep " + success +
           "?\n";
  }
  return "decided after " + std::to_string(*bet.decidedAfter()) + " episodes: the engine " +
         (bet.verdict() == Verdict::kKeeps ? "keeps" : "does not keep") + " " + success + "\n";
}

}  // namespace sim2sim
