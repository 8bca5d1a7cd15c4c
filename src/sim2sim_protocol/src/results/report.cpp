// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/report.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/split.hpp"
#include "sim2sim_protocol/results/headline.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {

using nlohmann::json;
using pusht::fixedText;
using pusht::roundToMicro;
using pusht::shortestText;

namespace {

template <class Number>
Number numberFrom(const std::string& text) {
  Number number{};
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;  // what is not all of a number does not give the same text again
}

/// null where there is none.
json rounded(double value) { return std::isfinite(value) ? json(readable(value)) : json(); }

json rounded(const std::optional<Interval>& interval) {
  return interval ? json{rounded(interval->low), rounded(interval->high)} : json();
}

constexpr int kStatisticsFormat = 2;  // of statistics.json
constexpr std::array kShownQuantiles = {0.05, 0.25, 0.75, 0.95};
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kFixedColumns = 5;    // those before the quantities
constexpr std::size_t kPartingColumns = 3;  // those behind them

std::string csvHead() {
  std::string head = "episode,seed,mode,steps,success";
  for (const Quantity& quantity : kQuantities) {
    head.append(",").append(quantity.name).append("_").append(quantity.unit);
  }
  return head + ",parting_step,parting_cause,parting_first\n";
}

std::string csvRow(const EpisodeResult& episode, const std::string& mode, const RolloutResult& result) {
  const std::string success = result.success ? "true" : "false";
  std::string row = std::to_string(episode.index) + "," + (episode.seed ? std::to_string(*episode.seed) : "") + "," +
                    mode + "," + std::to_string(result.steps) + "," + success;
  for (const double value : result.quantities) {
    row.append(",").append(std::isnan(value) ? "" : shortestText(value));
  }
  if (!result.parting) {
    return row + ",,,\n";
  }
  return row + "," + std::to_string(result.parting->step) + "," + nameOf(result.parting->cause).name + "," +
         nameOf(result.parting->first) + "\n";
}

/// Of a text that ends with one, or in the midst of one.
std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines = pusht::split(text, '\n');
  if (lines.back().empty()) {
    lines.pop_back();
  }
  return lines;
}

/// None where the cells name none.
std::optional<Parting> partingFrom(const std::string& step, const std::string& cause, const std::string& first) {
  const auto known = std::find_if(kCauses.begin(), kCauses.end(), [&](const auto& name) { return cause == name.name; });
  const auto who = std::find(kFirstNames.begin(), kFirstNames.end(), first);
  if (known == kCauses.end() || who == kFirstNames.end()) {
    return std::nullopt;
  }
  return Parting{numberFrom<int>(step), known->cause, static_cast<First>(who - kFirstNames.begin())};
}

/// The row that csvRow() wrote, as far as it can be read.
void readCsvRow(const std::string& row, EpisodeResult& episode, RolloutResult& result) {
  std::vector<std::string> cells = pusht::split(row, ',');
  cells.resize(kFixedColumns + kQuantities.size() + kPartingColumns);
  episode.index = numberFrom<int>(cells[0]);
  episode.seed = cells[1].empty() ? std::nullopt : std::optional(numberFrom<std::uint64_t>(cells[1]));
  result.steps = numberFrom<int>(cells[3]);
  result.success = cells[4] == "true";
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    const std::string& cell = cells[kFixedColumns + i];
    result.quantities[i] = cell.empty() ? kNone : numberFrom<double>(cell);
  }
  const std::size_t behind = kFixedColumns + kQuantities.size();
  result.parting = partingFrom(cells[behind], cells[behind + 1], cells[behind + 2]);
}

/// Of the samples of a quantity.
json distribution(std::vector<double> samples, const Quantity& quantity) {
  json figures = {{"episodes", samples.size()}};
  if (samples.empty()) {
    return figures;
  }
  const Estimate mean = meanOf(samples, quantity);
  std::sort(samples.begin(), samples.end());
  const Estimate median = medianOf(samples);
  figures["mean"] = rounded(mean.value);
  figures["mean_interval"] = rounded(mean.interval);
  figures["standard_deviation"] = samples.size() < 2 ? json() : rounded(standardDeviation(samples));
  figures["median"] = rounded(median.value);
  figures["median_interval"] = rounded(median.interval);
  for (const double probability : kShownQuantiles) {
    figures["quantiles"][shortestText(probability)] = rounded(quantileOf(samples, probability));
  }
  return figures;
}

/// Of the table.
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
std::string partedText(const Partings& partings) {
  const std::string count = std::to_string(partings.parted) + " of " + std::to_string(partings.episodes);
  return partings.median_step ? count + ", half by " + fixedText(*partings.median_step * pusht::kControlStep, 1) + " s"
                              : count;
}

/// "most at: sticking on bar, 17"
std::string causeText(const Partings& partings) {
  if (partings.parted == 0) {
    return "";
  }
  const CauseName& cause = mostFrequentCause(partings);
  return std::string("most at: ") + cause.label + ", " +
         std::to_string(partings.causes[static_cast<std::size_t>(cause.cause)]);
}

/// The replay's divergences, a column each, with what they must be read against.
bool isOfCourse(std::size_t rollout, std::size_t quantity) {
  return rollout == kEngineReplay && kQuantities[quantity].course_key != nullptr;
}

std::string divergenceLines(const Protocol& protocol, const Summary& summary) {
  std::array<std::string, kDivergencePairs.size()> units;
  std::array<std::string, kDivergencePairs.size()> labels;
  for (std::size_t i = 0; i < kDivergencePairs.size(); ++i) {
    const Quantity& quantity = kQuantities[quantityIndex(kDivergencePairs[i].divergence)];
    units[i] = quantity.unit;
    labels[i] = quantity.label;
  }
  const Summary::Yardsticks& yardsticks = summary.yardsticks[kEngineReplay];
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
  const auto median = [&](std::size_t i) { return cell(yardsticks[i].median, units[i]); };
  const auto minus_null = [&](std::size_t i) {
    return signedText(yardsticks[i].minus_null.value, yardsticks[i].minus_null.interval, units[i], kDigits);
  };
  const auto over_floor = [&](std::size_t i) { return timesText(yardsticks[i].over_floor); };
  std::string lines = line("divergence, open loop", labels[0], labels[1]) + line("  mean", mean(0), mean(1)) +
                      line("  median", median(0), median(1)) + line("  - null model", minus_null(0), minus_null(1));
  if (std::isfinite(yardsticks[0].over_floor)) {
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
      line("  beyond the bound", partedText(summary.partings), causeText(summary.partings));
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (const int every = probes[i].anchor_every; every > 0) {
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

json outcomes(const Outcomes& outcomes) {
  return {{"both_succeed", outcomes.table.both},
          {"only_reference_succeeds", outcomes.table.first_only},
          {"only_engine_succeeds", outcomes.table.second_only},
          {"neither_succeeds", outcomes.table.neither},
          {"success_difference", rounded(outcomes.table.difference())},
          {"success_difference_interval", rounded(outcomes.difference_interval)},
          {"success_difference_p", outcomes.p},
          {"success_difference_exact_p", outcomes.p_exact}};
}

/// The keys of metrics.json that say how to read a mean divergence.
json yardstick(const std::string& name, const std::string& unit, const Yardstick& yardstick) {
  const std::optional<bool> beats_null = yardstick.beatsNull();
  return {{name + "_median_" + unit, rounded(yardstick.median.value)},
          {name + "_median_interval_" + unit, rounded(yardstick.median.interval)},
          {name + "_minus_null_" + unit, rounded(yardstick.minus_null.value)},
          {name + "_minus_null_interval_" + unit, rounded(yardstick.minus_null.interval)},
          {name + "_share_of_null", rounded(yardstick.share_of_null)},
          {name + "_over_floor", rounded(yardstick.over_floor)},
          {name + "_beats_null", beats_null ? json(*beats_null) : json()}};
}

}  // namespace

std::string metricName(const std::string& rollout, const Quantity& quantity) {
  return rollout == modeName(kEngineReplay) && quantity.course_key != nullptr ? quantity.course_key
                                                                              : rollout + "_" + quantity.name;
}

std::optional<Interval> transferInterval(const RunConfiguration& configuration, const Outcomes& outcomes) {
  return configuration.protocol.until_decided ? std::optional(transferSequence(outcomes.table))
                                              : outcomes.transfer_interval;
}

json metrics(const RunConfiguration& configuration, const Summary& summary) {
  json metrics = describe(configuration);
  metrics["episodes"] = summary.episodes;  // fewer than asked for, where it was decided before
  metrics.update({
      {"engine_success_rate", roundToMicro(summary.engine.rate)},
      {"confidence", kConfidence},
      {"engine_successes", summary.engine.successes},
      {"engine_success_interval", rounded(summary.engine.interval)},
      {"reference_success_rate", roundToMicro(summary.reference.rate)},
      {"reference_successes", summary.reference.successes},
      {"reference_success_interval", rounded(summary.reference.interval)},
      {"transfer", rounded(summary.outcomes.transfer.value_or(kNone))},
      {"transfer_interval", rounded(summary.outcomes.transfer_interval)},
  });
  metrics.update(outcomes(summary.outcomes));
  const std::vector<std::string> rollouts = configuration.protocol.rolloutNames();
  forEachQuantity(configuration.protocol, [&](std::size_t rollout, std::size_t i) {
    const std::string name = metricName(rollouts[rollout], kQuantities[i]);
    const std::string unit = kQuantities[i].unit;
    metrics[name + "_" + unit] = isOfCourse(rollout, i) ? json(printedMean(summary, rollout, i).value)
                                                        : rounded(summary.means[rollout][i].value);
    metrics[name + "_interval_" + unit] = rounded(summary.means[rollout][i].interval);
  });
  for (std::size_t rollout = kReferenceClosed + 1; rollout < rollouts.size(); ++rollout) {
    for (std::size_t i = 0; i < kDivergencePairs.size(); ++i) {
      const Quantity& quantity = kQuantities[quantityIndex(kDivergencePairs[i].divergence)];
      metrics.update(yardstick(metricName(rollouts[rollout], quantity), quantity.unit, summary.yardsticks[rollout][i]));
    }
  }
  const Partings& partings = summary.partings;
  metrics["parted"] = partings.parted;
  metrics["median_parting_step"] = partings.median_step ? json(*partings.median_step) : json();
  metrics["floor_parted"] = summary.floor ? json(summary.floor->parted) : json();
  const bool predictable = !summary.floor || !summary.floor->median_step;
  metrics["predictability_horizon_step"] = predictable ? json() : json(*summary.floor->median_step);
  if (configuration.reference.name == kCourseReference) {  // as the course calls them
    for (const char* key : {"success_rate", "successes", "success_interval"}) {
      metrics[std::string("mj_") + key] = metrics[std::string("reference_") + key];
    }
  }
  return metrics;
}

json decision(const TransferBet& bet, double share) {
  constexpr std::array kVerdicts = {"undecided", "keeps", "does not keep"};
  const std::optional<int> after = bet.decidedAfter();
  return {{"share", share},
          {"verdict", kVerdicts.at(static_cast<std::size_t>(bet.verdict()))},
          {"episodes", after ? json(*after) : json()},
          {"holds_when_stopped", {"transfer_sequence"}},
          {"transfer_sequence", rounded(transferSequence(bet.counts()))}};
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

std::string doubtAboutPolicy(const json& metrics, const json& provenance) {
  const json hash = provenance.value(json::json_pointer("/policy/sha256"), json());
  const bool is_checkpoint = hash.is_string() && !hash.get_ref<const std::string&>().empty();
  if (!is_checkpoint || metrics.at("reference_successes").get<int>() > 0) {
    return "";
  }
  const bool at_home = metrics.at("reference_simulator") == kCourseReference;
  return "policy " + metrics.at("policy").get<std::string>() + " never succeeds in the reference" +
         (at_home ? ", the simulator it was trained in" : "") +
         ". It looks untrained or stale: the figures measure the policy, not the gap between the simulators.";
}

std::string jsonText(const json& json) {
  constexpr int kIndent = 2;
  return json.dump(kIndent, ' ', true, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string episodesCsv(const Protocol& protocol, const std::vector<EpisodeResult>& episodes) {
  const std::vector<std::string> modes = protocol.rolloutNames();
  std::string csv = csvHead();
  for (const EpisodeResult& episode : episodes) {
    for (std::size_t i = 0; i < modes.size(); ++i) {
      csv += csvRow(episode, modes[i], episode.rollouts.at(i));
    }
  }
  return csv;
}

std::vector<EpisodeResult> episodesFromCsv(const Protocol& protocol, const std::string& text) {
  const std::vector<std::string> lines = linesOf(text);
  const std::size_t rollouts = protocol.rolloutNames().size();
  const std::size_t count = lines.empty() ? 0 : (lines.size() - 1) / rollouts;
  std::vector<EpisodeResult> episodes(count);
  for (std::size_t i = 0; i < count; ++i) {
    episodes[i].rollouts.resize(rollouts);
    for (std::size_t rollout = 0; rollout < rollouts; ++rollout) {
      readCsvRow(lines[1 + i * rollouts + rollout], episodes[i], episodes[i].rollouts[rollout]);
    }
  }
  const std::vector<std::string> expected = linesOf(episodesCsv(protocol, episodes));
  const auto [found, wanted] = std::mismatch(lines.begin(), lines.end(), expected.begin(), expected.end());
  if (found != lines.end() || wanted != expected.end()) {
    throw pusht::InvalidInput("line " + std::to_string(found - lines.begin() + 1) +
                              ": must be a line of episodes.csv as it was written");
  }
  return episodes;
}

std::string cell(const SuccessRate& rate) { return std::to_string(rate.successes) + "  " + shareText(rate); }

std::string shareText(const SuccessRate& rate) { return figureText(rate.rate, rate.interval, 3); }

std::string cell(const Estimate& estimate, const std::string& unit) {
  constexpr int kDigits = 4;
  const std::string value = fixedText(readable(estimate.value), kDigits) + " " + unit;
  return estimate.interval ? value + " " + bracketed(*estimate.interval, kDigits) : value;
}

Estimate printedMean(const Summary& summary, std::size_t rollout, std::size_t quantity) {
  Estimate mean = summary.means[rollout][quantity];
  if (isOfCourse(rollout, quantity)) {
    mean.value = roundToMicro(mean.value);
  }
  return mean;
}

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

std::string doubtMark(const Summary& summary, std::string_view divergence) {
  const std::string mark = markOf(summary, divergence);
  return mark.empty() ? mark : " " + mark;
}

std::string markOf(const Summary& summary, std::string_view divergence) {
  for (std::size_t i = 0; i < kDivergencePairs.size(); ++i) {
    if (divergence == kDivergencePairs[i].divergence) {
      return markOf(summary.yardsticks[kEngineReplay][i].beatsNull());
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

json statistics(const RunConfiguration& configuration, const std::vector<EpisodeResult>& episodes) {
  const Protocol& protocol = configuration.protocol;
  const PairTable successes = pairsOf(episodes, kReferenceClosed, episodes, kEngineClosed);
  json statistics = {{"format", kStatisticsFormat},
                     {"confidence", kConfidence},
                     {"episodes", episodes.size()},
                     {"headline", toJson(headlineOf(configuration, successes))}};
  const std::vector<std::string> rollouts = protocol.rolloutNames();
  forEachQuantity(protocol, [&](std::size_t rollout, std::size_t i) {
    const std::string name = std::string(kQuantities[i].name) + "_" + kQuantities[i].unit;
    statistics["rollouts"][rollouts[rollout]][name] = distribution(samplesOf(episodes, rollout, i), kQuantities[i]);
  });
  for (std::size_t rollout = kReferenceClosed + 1; rollout < rollouts.size(); ++rollout) {
    statistics["rollouts"][rollouts[rollout]]["parting"] = toJson(partingsOf(episodes, rollout));
  }
  return statistics;
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
