// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/table.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/headline.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {
namespace {

using pusht::fixedText;

/// Line of the table.
std::string line(const std::string& head, const std::string& left, const std::string& right) {
  constexpr std::size_t kHead = 24;
  constexpr std::size_t kColumn = 32;
  return padded(head, kHead) + padded(left, kColumn) + right + "\n";
}

/// "1.3 times", "110 times"; "undefined" for NaN
std::string timesText(double multiple) {
  if (std::isnan(multiple)) {
    return "undefined";
  }
  constexpr int kDigits = 2;
  constexpr double kLong = 100.0;  // from here on two digits alone would have an exponent
  const std::string text = pusht::significantText(readable(multiple), kDigits);
  return (multiple < kLong ? text : fixedText(pusht::decimal<double>(text).value_or(multiple), 0)) + " times";
}

/// "46 of 50, half by 1.3 s"
std::string partedText(const FirstDivergences& first_divergences) {
  const std::string count =
      std::to_string(first_divergences.parted) + " of " + std::to_string(first_divergences.episodes);
  return first_divergences.median_step
             ? count + ", half by " + fixedText(*first_divergences.median_step * pusht::kControlStep, 1) + " s"
             : count;
}

/// "most at: sticking on bar, 17"
std::string causeText(const FirstDivergences& first_divergences) {
  if (first_divergences.parted == 0) {
    return "";
  }
  const CauseName& cause = mostFrequentCause(first_divergences);
  return std::string("most at: ") + cause.label + ", " +
         std::to_string(first_divergences.causes[static_cast<std::size_t>(cause.cause)]);
}

std::string divergenceLines(const Protocol& protocol, const Summary& summary) {
  std::array<std::string, kDivergencePairs.size()> units;
  std::array<std::string, kDivergencePairs.size()> labels;
  for (std::size_t i = 0; i < kDivergencePairs.size(); ++i) {
    const Quantity& quantity = kQuantities[quantityIndex(kDivergencePairs[i].divergence)];
    units[i] = quantity.unit;
    labels[i] = quantity.label;
  }
  const Summary::Baselines& baselines = summary.baselines[kEngineReplay];
  constexpr int kDigits = 4;
  bool any_doubt = false;
  bool any_too_few = false;
  const auto mean = [&](std::size_t i) {
    const Quantity& quantity = kQuantities[quantityIndex(kDivergencePairs[i].divergence)];
    const std::string mark = markOf(summary, quantity.name);
    any_doubt = any_doubt || mark == markOf(false);
    any_too_few = any_too_few || mark == markOf(std::nullopt);
    return cell(printedMean(summary, kEngineReplay, quantityIndex(quantity.name)), units[i]) +
           doubtMark(summary, quantity.name);
  };
  const auto median = [&](std::size_t i) { return cell(baselines[i].median, units[i]); };
  const auto minus_null = [&](std::size_t i) {
    return signedText(baselines[i].minus_null.value, baselines[i].minus_null.interval, units[i], kDigits);
  };
  const auto over_floor = [&](std::size_t i) { return timesText(baselines[i].over_floor); };
  std::string lines = line("divergence, open loop", labels[0], labels[1]) + line("  mean", mean(0), mean(1)) +
                      line("  median", median(0), median(1)) + line("  - null model", minus_null(0), minus_null(1));
  if (std::isfinite(baselines[0].over_floor)) {
    lines += line("  / floor (1e-6 m)", over_floor(0), over_floor(1));
  }
  if (2 * summary.unmoved_floors > summary.episodes) {
    lines += line("  floor (1e-9 m)",
                  "exactly 0 in " + std::to_string(summary.unmoved_floors) + " of " + std::to_string(summary.episodes) +
                      " episodes: the reference does not see so small a shift",
                  "");
  }
  const auto absorbed = [&](const char* quantity) {
    const Estimate& estimate = summary.mean(kEngineClosed, quantity);
    return signedText(estimate.value, estimate.interval, kQuantities[quantityIndex(quantity)].unit, kDigits);
  };
  lines +=
      line("  less in closed loop", absorbed("absorbed_position_divergence"), absorbed("absorbed_angle_divergence")) +
      line("  beyond the bound", partedText(summary.first_divergences), causeText(summary.first_divergences));
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (const int every = probes[i].reset_every; every > 0) {
      const auto error = [&](const char* quantity) {
        return cell(summary.mean(kModeCount + i, quantity), kQuantities[quantityIndex(quantity)].unit);
      };
      lines += line("  made in " + std::to_string(every) + (every == 1 ? " step" : " steps"),
                    error("anchor_position_error"), error("anchor_angle_error"));
    }
  }
  return lines + (any_doubt ? "(!) not shown to be less than that of a tee that never moves\n" : "") +
         (any_too_few ? std::string("(?) ") + kTooFewToCompare + " it with that of a tee that never moves\n" : "");
}

}  // namespace

std::string transferText(const RunConfiguration& configuration, const Outcomes& outcomes) {
  if (!outcomes.transfer) {
    return "undefined: the reference never succeeds";
  }
  const auto text = [&](double share) {
    return std::isinf(share) ? "any" : transferNumber(configuration, share) + " %";
  };
  const std::optional<Interval> interval = transferInterval(configuration, outcomes);
  return text(*outcomes.transfer) + (interval ? " [" + text(interval->low) + ", " + text(interval->high) + "]" : "");
}

std::string shareText(const SuccessRate& rate) {
  constexpr int kDigits = 3;
  return fixedText(readable(rate.rate), kDigits) + " " + bracketed(rate.interval, kDigits);
}

std::string cell(const SuccessRate& rate) { return std::to_string(rate.successes) + "  " + shareText(rate); }

std::string cell(const Estimate& estimate, const std::string& unit) {
  constexpr int kDigits = 4;
  const std::string value = fixedText(readable(estimate.value), kDigits) + " " + unit;
  return estimate.interval ? value + " " + bracketed(*estimate.interval, kDigits) : value;
}

std::string doubtMark(const Summary& summary, std::string_view divergence) {
  const std::string mark = markOf(summary, divergence);
  return mark.empty() ? mark : " " + mark;
}

std::string markOf(const Summary& summary, std::string_view divergence) {
  for (std::size_t i = 0; i < kDivergencePairs.size(); ++i) {
    if (divergence == kDivergencePairs[i].divergence) {
      return markOf(summary.baselines[kEngineReplay][i].beatsNull());
    }
  }
  return "";
}

std::string divergences(const Summary& summary, const std::string& separator) {
  std::string text;
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    if (kQuantities[i].label != nullptr) {
      text.append(text.empty() ? "" : separator)
          .append(cell(printedMean(summary, kEngineReplay, i), kQuantities[i].unit));
      text.append(doubtMark(summary, kQuantities[i].name));
    }
  }
  return text;
}

std::string decisionText(const TransferBet& bet, double share) {
  const std::string known =
      "\n(the interval of the transfer holds whenever the run stops; the other intervals are those of a run of fixed "
      "length,\nand hold less often here)\n";
  constexpr int kDigits = 6;
  const std::string success = pusht::significantText(100.0 * share, kDigits) + " % of the reference's success";
  if (bet.verdict() == Verdict::kUndecided) {
    return "not decided after " + std::to_string(bet.counts().pairs()) + " episodes: does the engine keep " + success +
           "?" + known;
  }
  return "decided after " + std::to_string(*bet.decidedAfter()) + " episodes: the engine " +
         (bet.verdict() == Verdict::kKeeps ? "keeps" : "does not keep") + " " + success + known;
}

std::string table(const RunConfiguration& configuration, const Summary& summary) {
  const Outcomes& outcomes = summary.outcomes;
  const PairTable& pairs = outcomes.table;
  std::string table =
      headlineOf(configuration, pairs).text() + "\n" +
      line("", configuration.reference.title + " (reference)", configuration.engine.title) +
      line("success, closed loop", cell(summary.reference), cell(summary.engine)) +
      line("transfer", "", transferText(configuration, outcomes)) +
      line("engine - reference", "McNemar p " + probabilityText(outcomes.p),
           signedText(outcomes.table.difference(), outcomes.difference_interval, "", 3)) +
      line("the same episodes",
           "both " + std::to_string(pairs.both) + ", reference only " + std::to_string(pairs.first_only),
           "engine only " + std::to_string(pairs.second_only) + ", neither " + std::to_string(pairs.neither)) +
      divergenceLines(configuration.protocol, summary);
  return table + "(" + std::to_string(summary.episodes) + " episodes; in brackets " +
         fixedText(100.0 * kConfidence, 0) + " % intervals" +
         (summary.episodes < kFewestPairs ? "; most need " + std::to_string(kFewestEpisodes) +
                                                " episodes, differences " + std::to_string(kFewestPairs)
                                          : "") +
         ". Null model: a tee that never moves.)\n";
}

}  // namespace sim2sim
