// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/table.hpp"

#include <algorithm>
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

constexpr std::size_t kHead = 24;  // width of the first column

/// Line of the table, whose first column has `width`.
std::string line(const std::string& head, const std::string& left, const std::string& right,
                 std::size_t width = kHead) {
  constexpr std::size_t kColumn = 32;
  return padded(head, width) + (right.empty() ? left : padded(left, kColumn) + right) + "\n";
}

/// "position" or "angle", of a divergence in kDivergencePairs over whole episodes.
std::string labelOf(std::size_t pair) { return kQuantities[quantityIndex(kDivergencePairs[pair].divergence)].label; }

/// "46 of 50, half by 1.3 s"; `median_step` is when half of them were so far [control steps].
std::string countText(int some, int all, const std::optional<int>& median_step) {
  return std::to_string(some) + " of " + std::to_string(all) +
         (median_step ? ", half by " + fixedText(*median_step * pusht::kControlStep, 1) + " s" : "");
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

/// "3 moving, 1 lost": the other failures.
std::string otherEndingsText(const Endings& endings) {
  return std::to_string(endings.of(Ending::kMoving)) + " moving, " + std::to_string(endings.of(Ending::kLost)) +
         " lost";
}

/// "91 still, 28 moving, 0 lost": the pushers of the stuck failures.
std::string stuckPushersText(const Endings& endings) {
  const auto count = [&](PusherEnding pusher) {
    return std::to_string(endings.stuck_pushers[static_cast<std::size_t>(pusher)]) + " " + nameOf(pusher);
  };
  return count(PusherEnding::kStill) + ", " + count(PusherEnding::kMoving) + ", " + count(PusherEnding::kLost);
}

/// Lines on how failures end, as far as there are any.
std::string endingLines(const Protocol& protocol, const EndingsOfPairs& endings) {
  const int failures = endings.reference.failures() + endings.engine.failures();
  const int stuck = endings.reference.of(Ending::kStuck) + endings.engine.of(Ending::kStuck);
  const auto both = [&](const std::string& head, const auto& text) {
    return line(head, text(endings.reference), protocol.alone ? "" : text(endings.engine));
  };
  const auto stuck_text = [](const Endings& of) {
    return countText(of.of(Ending::kStuck), of.failures(), of.median_still_step);
  };
  const bool has_limited = std::max(endings.reference.limitedShare(), endings.engine.limitedShare()) > kManyLimited;
  const auto limited_text = [](const Endings& of) { return percent(of.limitedShare()); };
  return (has_limited ? both("commands at 1 m/s", limited_text) : "") +
         (failures == 0 ? "" : both("  failures stuck", stuck_text)) +
         (stuck == 0 ? "" : both("    their pusher", stuckPushersText)) +
         (failures == stuck ? "" : both("  other failures", otherEndingsText));
}

/// Lines of the coverage, and of success by other rules, in a run that has them.
std::string coverageLines(const Protocol& protocol, const Summary& summary) {
  const auto both = [&](const char* head, const char* quantity) {
    return line(head, cell(summary.mean(kReferenceClosed, quantity), ""),
                protocol.alone ? "" : cell(summary.mean(kEngineClosed, quantity), ""));
  };
  return protocol.hasCoverage()
             ? both("  coverage at its best", "largest_coverage") + both("  coverage at the end", "final_coverage") +
                   both("  above 0.95 at best", "covered_at_best") + both("  above 0.95 at the end", "covered_at_end") +
                   both("  20 mm, 20 degrees", "within_20mm_20deg")
             : "";
}

/// Line on the stuck rollouts among the pairs; empty if there are none.
std::string stuckPairsLine(const EndingsOfPairs& endings) {
  if (endings.reference.of(Ending::kStuck) + endings.engine.of(Ending::kStuck) == 0) {
    return "";
  }
  return line("  stuck where it fails", "reference only " + std::to_string(endings.only_reference_engine_stuck),
              "engine only " + std::to_string(endings.only_engine_reference_stuck) + ", neither " +
                  std::to_string(endings.neither_reference_stuck) + " reference, " +
                  std::to_string(endings.neither_engine_stuck) + " engine");
}

/// Meaning of the mark (?).
std::string noComparisonText(const Protocol& protocol) {
  return protocol.until_decided ? std::string(
                                      "not compared with that of a tee that never moves: no interval of it "
                                      "holds in a run that may stop early")
                                : std::string(kTooFewToCompare) + " it with that of a tee that never moves";
}

/// "35 % of the variance": what the noise of policy and loop makes; empty where that is not known.
std::string noisePart(const NoiseSplit& split) {
  const double whole = split.starts.value + split.repeats.value;
  return whole > 0.0 ? percent(split.repeats.value / whole) + " of the variance" : "";
}

/// Lines of the two parts of the variance of success; none without repeats.
std::string noiseLines(const Protocol& protocol, const Summary& summary) {
  if (!summary.noise) {
    return "";
  }
  const auto both = [&](const std::string& head, const Estimate& of_reference, const Estimate& of_engine) {
    return line(head, cell(of_reference, ""), protocol.alone ? "" : cell(of_engine, ""));
  };
  const auto& [of_reference, of_engine, of_divergences] = *summary.noise;
  return both("  variance of starts", of_reference.starts, of_engine.starts) +
         both("  variance of repeats", of_reference.repeats, of_engine.repeats);
}

/// "100 episodes", or "100 episodes, 4 of each start"
std::string episodesText(const Protocol& protocol, const Summary& summary) {
  return std::to_string(summary.episodes) + " episodes" +
         (protocol.repeats == 1 ? "" : ", " + std::to_string(protocol.repeats) + " of each start");
}

/// Marks that a table has, which are explained below it.
struct Marks {
  bool doubt = false;    ///< (!)
  bool too_few = false;  ///< (?)
};

/// Lines of the divergences over a horizon; none if no episode lasts that long.
std::string horizonLines(const Summary& summary, const Horizon& horizon, Marks& marks) {
  constexpr int kDigits = 4;
  const auto both = [&](const std::string& head, const auto& text) {
    const auto of = [&](std::size_t i) {
      const Quantity& quantity = kQuantities[quantityIndex(kDivergencePairs[i].divergence)];
      return text(summary.baselines[kEngineReplay][i], quantity);
    };
    return line(head, of(horizon.first_pair), of(horizon.first_pair + 1));
  };
  const auto mean = [&](const BaselineComparison& baseline, const Quantity& quantity) {
    const std::string mark = markOf(baseline.beatsNull());
    marks.doubt = marks.doubt || mark == markOf(false);
    marks.too_few = marks.too_few || mark == markOf(std::nullopt);
    return cell(printedMean(summary, kEngineReplay, quantityIndex(quantity.name)), quantity.unit) +
           (mark.empty() ? "" : " " + mark);
  };
  const auto carried = [](const BaselineComparison& baseline, const Quantity& /*quantity*/) {
    return baseline.isMostlyOfLargest() ? percent(baseline.share_of_largest) + " of the mean" : "";
  };
  const auto median = [](const BaselineComparison& baseline, const Quantity& quantity) {
    return cell(baseline.median, quantity.unit);
  };
  const auto minus_null = [](const BaselineComparison& baseline, const Quantity& quantity) {
    return signedText(baseline.minus_null.value, baseline.minus_null.interval, quantity.unit, kDigits);
  };
  const auto over_floor = [](const BaselineComparison& baseline, const Quantity& /*quantity*/) {
    return timesText(baseline.over_floor, baseline.over_floor_interval);
  };
  const auto over_variants = [](const BaselineComparison& baseline, const Quantity& /*quantity*/) {
    return timesText(baseline.over_variants, baseline.over_variants_interval);
  };
  const BaselineComparison& position = summary.baselines[kEngineReplay][horizon.first_pair];
  const BaselineComparison& angle = summary.baselines[kEngineReplay][horizon.first_pair + 1];
  if (position.episodes == 0 && angle.episodes == 0) {
    return "";
  }
  const bool is_whole = horizon.first_pair == 0;
  const std::string count =
      position.starts < summary.outcomes.starts ? " (n " + std::to_string(position.starts) + ")" : "";
  return both(std::string("  ") + horizon.title + count, mean) +
         (position.isMostlyOfLargest() || angle.isMostlyOfLargest() ? both("    largest 5 % carry", carried) : "") +
         (is_whole ? both("    median", median) : "") +
         (is_whole && summary.noise ? line("    made by repeats", noisePart(summary.noise->divergences[0]),
                                           noisePart(summary.noise->divergences[1]))
                                    : "") +
         both("    - null model", minus_null) +
         (is_whole && std::isfinite(position.over_floor) ? both("    / floor (1e-6 m)", over_floor) : "") +
         (std::isfinite(position.over_variants) ? both("    / largest variant", over_variants) : "");
}

std::string stepsText(int steps) { return std::to_string(steps) + (steps == 1 ? " step" : " steps"); }

/// Lines of the pushes of state-reset replays; none without a push. They stand before the divergence: their
/// direction error ranks engines by lost success better than their position error (docs/findings.md, P1).
std::string pushLines(const RunConfiguration& configuration, const Summary& summary) {
  std::string lines;
  const std::vector<Probe> probes = configuration.protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const auto mean = [&](const char* quantity) { return summary.mean(rolloutOfProbe(i), quantity); };
    if (probes[i].reset_every > 0 && !std::isnan(mean("pushes_missed").value)) {
      const std::string reference = inSentence(configuration.reference.title);
      lines += padded("  in " + stepsText(probes[i].reset_every), kHead) + "direction error " +
               cell(mean("push_direction_error"), "rad") + "\n" + padded("    missed", kHead) +
               pushText(reference, mean("pushes_missed"), mean("pushes_turned")) + "\n";
    }
  }
  return lines.empty() ? "" : "pushes, open loop\n" + lines;
}

std::string divergenceLines(const RunConfiguration& configuration, const Summary& summary, Marks& marks) {
  constexpr int kDigits = 4;
  std::string lines = line("divergence, open loop", labelOf(0), labelOf(1));
  for (const Horizon& horizon : kHorizons) {
    lines += horizonLines(summary, horizon, marks);
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
  const FirstDivergences& first = summary.first_divergences;
  lines +=
      line("  less in closed loop", absorbed("absorbed_position_divergence"), absorbed("absorbed_angle_divergence")) +
      line("  beyond the bound", countText(first.parted, first.episodes, first.median_step), causeText(first));
  const std::vector<Probe> probes = configuration.protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (const int every = probes[i].reset_every; every > 0) {
      const auto error = [&](const char* quantity) {
        return cell(summary.mean(rolloutOfProbe(i), quantity), kQuantities[quantityIndex(quantity)].unit);
      };
      lines += line("  made in " + stepsText(every), error("anchor_position_error"), error("anchor_angle_error"));
    }
  }
  return lines;
}

/// Meanings of the marks that a table has.
std::string footnotes(const Protocol& protocol, const Marks& marks) {
  return std::string(marks.doubt ? "(!) not shown to be less than that of a tee that never moves\n" : "") +
         (marks.too_few ? "(?) " + noComparisonText(protocol) + "\n" : "");
}

/// Side of the reference's model variants on which the engine's divergence is, "farther" or "nearer"; empty if that is
/// not shown.
std::string sideOf(const BaselineComparison& baseline) {
  const std::optional<Interval>& interval = baseline.over_variants_interval;
  return !interval ? "" : interval->low > 1.0 ? "farther" : interval->high < 1.0 ? "nearer" : "";
}

/// "In position, over the first 2 s, the two-mass engine is farther from MuJoCo than MuJoCo's largest model variant.",
/// and the angle likewise; empty if no episode lasts that long.
std::string sideText(const RunConfiguration& configuration, const Summary& summary, const Horizon& horizon) {
  const std::string& reference = configuration.reference.title;
  std::string text;
  for (std::size_t i = 0; i < kWholeEpisodePairs; ++i) {
    const BaselineComparison& baseline = summary.baselines[kEngineReplay][horizon.first_pair + i];
    if (baseline.episodes == 0) {
      continue;
    }
    const std::string side = sideOf(baseline);
    text.append("In ").append(labelOf(i)).append(", over the ").append(horizon.title).append(", ");
    text.append(side.empty() ? "it is not shown whether " : "").append("the ").append(configuration.engine.title);
    text.append(side == "nearer" ? " is nearer to " : " is farther from ").append(reference);
    text.append(" than ").append(reference).append("'s largest model variant.\n");
  }
  return text;
}

/// Lines on the model variants: how far the reference is from itself, on which side of that the engine is, and how much
/// success changes.
std::string variantLines(const RunConfiguration& configuration, const Summary& summary) {
  const std::vector<Probe> probes = configuration.protocol.probes();
  const Horizon& whole = kHorizons.back();
  const std::string head = configuration.reference.title + ", its variants";
  std::size_t width = std::max(kHead, head.size() + 2);
  for (const Probe& probe : probes) {
    width = std::max(width, probe.variant.size() + 4);  // two blanks on each side
  }
  std::string lines;
  if (!configuration.protocol.model_variants.empty()) {
    const auto over_whole = [&](std::size_t pair) { return labelOf(pair) + ", " + whole.title; };
    lines += line(head, over_whole(0), over_whole(1), width);
  }
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (probes[i].world == ProbedWorld::kVariant && !probes[i].closed) {
      const auto mean = [&](std::size_t pair) {
        const std::size_t quantity = quantityIndex(kDivergencePairs[pair].divergence);
        return cell(printedMean(summary, rolloutOfProbe(i), quantity), kQuantities[quantity].unit);
      };
      lines += line("  " + probes[i].variant, mean(0), mean(1), width);
    }
  }
  if (!configuration.protocol.model_variants.empty()) {
    lines += sideText(configuration, summary, kHorizons.front()) + sideText(configuration, summary, whole);
  }
  if (!summary.closed_variants.empty()) {
    lines += line(head, "success, closed loop", "less reference", width);
  }
  for (const ClosedVariant& variant : summary.closed_variants) {
    lines += line("  " + configuration.protocol.probeOf(variant.rollout)->variant, cell(variant.success),
                  signedText(variant.outcomes.table.difference(), variant.outcomes.difference_interval, "", 3), width);
  }
  return lines;
}

/// Table of a run without an engine.
std::string tableAlone(const RunConfiguration& configuration, const Summary& summary, const std::string& headline) {
  const Protocol& protocol = configuration.protocol;
  return headline + line("", configuration.reference.title, "") +
         line("success, closed loop", cell(summary.reference), "") + coverageLines(protocol, summary) +
         noiseLines(protocol, summary) + endingLines(protocol, summary.endings) + variantLines(configuration, summary) +
         "(" + episodesText(protocol, summary) + "; in brackets " + fixedText(100.0 * kConfidence, 0) +
         " % intervals over other initial states" + (protocol.repeats > 1 ? " and other noise" : "") +
         ", not over other trainings of the policy)\n";
}

}  // namespace

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

std::string table(const RunConfiguration& configuration, const Summary& summary) {
  const Outcomes& outcomes = summary.outcomes;
  const PairTable& pairs = outcomes.table;
  const Headline headline = headlineOf(configuration, outcomes, summary.endings);
  const std::string head = (headline.caveat.empty() ? "" : headline.caveat + "\n") + headline.text() + "\n";
  if (configuration.protocol.alone) {
    return tableAlone(configuration, summary, head);
  }
  Marks marks;
  std::string table =
      head + line("", configuration.reference.title + " (reference)", configuration.engine.title) +
      line("success, closed loop", cell(summary.reference), cell(summary.engine)) +
      coverageLines(configuration.protocol, summary) + noiseLines(configuration.protocol, summary) +
      endingLines(configuration.protocol, summary.endings) +
      line("transfer", "", transferText(configuration, outcomes)) +
      line("engine - reference", outcomes.p ? "McNemar p " + probabilityText(*outcomes.p) : "",
           signedText(outcomes.table.difference(), outcomes.difference_interval, "", 3)) +
      line("the same episodes",
           "both " + std::to_string(pairs.both) + ", reference only " + std::to_string(pairs.first_only),
           "engine only " + std::to_string(pairs.second_only) + ", neither " + std::to_string(pairs.neither)) +
      stuckPairsLine(summary.endings) + pushLines(configuration, summary) +
      divergenceLines(configuration, summary, marks) + variantLines(configuration, summary);
  table += footnotes(configuration.protocol, marks);
  const std::string count = "(" + episodesText(configuration.protocol, summary) + "; in brackets ";
  const std::string confidence = fixedText(100.0 * kConfidence, 0) + " % ";
  if (configuration.protocol.until_decided) {
    return table + count + "the " + confidence +
           "interval that holds whenever the run stops; the others do not, and are left out. Null model: a tee that "
           "never moves.)\n";
  }
  const bool repeated = configuration.protocol.repeats > 1;
  return table + count + confidence + "intervals over other initial states" + (repeated ? " and other noise" : "") +
         ", not over other trainings of the policy" +
         (summary.outcomes.starts < kFewestPairs
              ? "; most need " + std::to_string(kFewestEpisodes) + (repeated ? " starts" : " episodes") +
                    ", divergences and differences " + std::to_string(kFewestPairs)
              : "") +
         ". Null model: a tee that never moves.)\n";
}

}  // namespace sim2sim
