// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/results/report.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <limits>
#include <sstream>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/numbers.hpp"

namespace sim2sim {

using nlohmann::json;
using pusht::fixedText;
using pusht::roundToMicro;
using pusht::shortestText;

namespace {

SuccessRate successRate(const std::vector<EpisodeResult>& episodes, Mode mode) {
  const auto successes = static_cast<int>(std::count_if(
      episodes.begin(), episodes.end(), [mode](const EpisodeResult& episode) { return episode.modes[mode].success; }));
  const auto trials = static_cast<int>(episodes.size());
  return {successes, static_cast<double>(successes) / trials, wilsonInterval(successes, trials)};
}

Mean meanOver(const std::vector<EpisodeResult>& episodes, Mode mode, std::size_t quantity) {
  std::vector<double> samples;
  samples.reserve(episodes.size());
  for (const EpisodeResult& episode : episodes) {
    samples.push_back(episode.modes[mode].quantities[quantity]);
  }
  return meanOf(samples);
}

json rounded(const std::optional<Interval>& interval) {
  return interval ? json{roundToMicro(interval->low), roundToMicro(interval->high)} : json();
}

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kFixedColumns = 5;  // those before the quantities

std::string csvHead() {
  std::string head = "episode,seed,mode,steps,success";
  for (const Quantity& quantity : kQuantities) {
    head.append(",").append(quantity.name).append("_").append(quantity.unit);
  }
  return head + "\n";
}

std::string csvRow(const EpisodeResult& episode, Mode mode) {
  const RolloutResult& result = episode.modes[mode];
  const std::string success = result.success ? "true" : "false";
  std::string row = std::to_string(episode.index) + "," + (episode.seed ? std::to_string(*episode.seed) : "") + "," +
                    modeName(mode) + "," + std::to_string(result.steps) + "," + success;
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    row.append(",").append(has(mode, kQuantities[i]) ? shortestText(result.quantities[i]) : "");
  }
  return row + "\n";
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) {
    parts.push_back(part);
  }
  return parts;
}

template <class Number>
Number numberFrom(const std::string& text) {
  Number number{};
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;  // what is not all of a number does not give the same text again
}

/// The row that csvRow() wrote, as far as it can be read.
void readCsvRow(const std::string& row, Mode mode, EpisodeResult& episode) {
  std::vector<std::string> cells = split(row, ',');
  cells.resize(kFixedColumns + kQuantities.size());
  episode.index = numberFrom<int>(cells[0]);
  episode.seed = cells[1].empty() ? std::nullopt : std::optional(numberFrom<std::uint64_t>(cells[1]));
  RolloutResult& result = episode.modes[mode];
  result.steps = numberFrom<int>(cells[3]);
  result.success = cells[4] == "true";
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    result.quantities[i] = has(mode, kQuantities[i]) ? numberFrom<double>(cells[kFixedColumns + i]) : kNone;
  }
}

std::string bracketed(const Interval& interval, int digits) {
  return "[" + fixedText(interval.low, digits) + ", " + fixedText(interval.high, digits) + "]";
}

std::string padded(const std::string& text, std::size_t width) {
  return text + std::string(width > text.size() ? width - text.size() : 1, ' ');
}

}  // namespace

Summary summarize(const std::vector<EpisodeResult>& episodes) {
  const SuccessRate reference = successRate(episodes, kReferenceClosed);
  const SuccessRate engine = successRate(episodes, kEngineClosed);
  std::optional<double> transfer;
  if (reference.successes > 0) {
    transfer = engine.rate / reference.rate;
  }
  Summary summary{static_cast<int>(episodes.size()), reference, engine, transfer, {}};
  forEachQuantity(
      [&](Mode mode, std::size_t quantity) { summary.means[mode][quantity] = meanOver(episodes, mode, quantity); });
  return summary;
}

std::string metricName(Mode mode, const Quantity& quantity) {
  return mode == kEngineReplay && quantity.course_key != nullptr ? quantity.course_key
                                                                 : std::string(modeName(mode)) + "_" + quantity.name;
}

json metrics(const RunConfiguration& configuration, const Summary& summary) {
  json metrics = describe(configuration);
  metrics.update({
      {"engine_success_rate", roundToMicro(summary.engine.rate)},
      {"confidence", kConfidence},
      {"engine_successes", summary.engine.successes},
      {"engine_success_interval", rounded(summary.engine.interval)},
      {"reference_success_rate", roundToMicro(summary.reference.rate)},
      {"reference_successes", summary.reference.successes},
      {"reference_success_interval", rounded(summary.reference.interval)},
      {"transfer", summary.transfer ? json(roundToMicro(*summary.transfer)) : json()},
  });
  forEachQuantity([&](Mode mode, std::size_t i) {
    const std::string name = metricName(mode, kQuantities[i]);
    const std::string unit = kQuantities[i].unit;
    metrics[name + "_" + unit] = roundToMicro(summary.means[mode][i].value);
    metrics[name + "_interval_" + unit] = rounded(summary.means[mode][i].interval);
  });
  if (configuration.reference.name == "mujoco") {  // as the course calls them
    for (const char* key : {"success_rate", "successes", "success_interval"}) {
      metrics[std::string("mj_") + key] = metrics[std::string("reference_") + key];
    }
  }
  return metrics;
}

std::string doubtAboutPolicy(const json& metrics, const json& provenance) {
  const json hash = provenance.value(json::json_pointer("/policy/sha256"), json());
  const bool is_checkpoint = hash.is_string() && !hash.get_ref<const std::string&>().empty();
  if (!is_checkpoint || metrics.at("reference_successes").get<int>() > 0) {
    return "";
  }
  return "policy " + metrics.at("policy").get<std::string>() +
         " never succeeds in the reference, the simulator it was trained in. It looks untrained or stale: the figures "
         "measure the policy, not the gap between the simulators.";
}

std::string jsonText(const json& json) {
  constexpr int kIndent = 2;
  return json.dump(kIndent, ' ', true, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string episodesCsv(const std::vector<EpisodeResult>& episodes) {
  std::string csv = csvHead();
  for (const EpisodeResult& episode : episodes) {
    for (const Mode mode : kModes) {
      csv += csvRow(episode, mode);
    }
  }
  return csv;
}

std::vector<EpisodeResult> episodesFromCsv(const std::string& text) {
  const std::vector<std::string> lines = split(text, '\n');
  const std::size_t count = lines.empty() ? 0 : (lines.size() - 1) / kModeCount;
  std::vector<EpisodeResult> episodes(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (const Mode mode : kModes) {
      readCsvRow(lines[1 + i * kModeCount + mode], mode, episodes[i]);
    }
  }
  const std::vector<std::string> expected = split(episodesCsv(episodes), '\n');
  const auto [found, wanted] = std::mismatch(lines.begin(), lines.end(), expected.begin(), expected.end());
  if (found != lines.end() || wanted != expected.end()) {
    throw pusht::InvalidInput("line " + std::to_string(found - lines.begin() + 1) +
                              ": must be a line of episodes.csv as it was written");
  }
  return episodes;
}

std::string cell(const SuccessRate& rate) {
  return std::to_string(rate.successes) + "  " + fixedText(rate.rate, 3) + " " + bracketed(rate.interval, 3);
}

std::string cell(const Mean& mean, const std::string& unit) {
  constexpr int kDigits = 4;
  const std::string value = fixedText(mean.value, kDigits) + " " + unit;
  const std::optional<Interval> interval = aboveZero(mean.interval);
  return interval ? value + " " + bracketed(*interval, kDigits) : value;
}

std::string divergences(const Summary& summary, const std::string& separator) {
  std::string text;
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    if (kQuantities[i].compares) {
      text.append(text.empty() ? "" : separator).append(cell(summary.means[kEngineReplay][i], kQuantities[i].unit));
    }
  }
  return text;
}

std::string table(const RunConfiguration& configuration, const Summary& summary) {
  constexpr std::size_t kFirst = 24;
  constexpr std::size_t kColumn = 30;
  const std::string transfer = summary.transfer ? fixedText(100.0 * *summary.transfer, 0) + " %" : "undefined";
  std::string table = padded("", kFirst) + padded(configuration.reference.title + " (reference)", kColumn) +
                      configuration.engine.title + "\n" + padded("success, closed loop", kFirst) +
                      padded(cell(summary.reference), kColumn) + cell(summary.engine) + "\n" +
                      padded("transfer", kFirst) + padded("", kColumn) + transfer + "\n";
  const char* first = "divergence, open loop";
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    if (kQuantities[i].compares) {
      table += padded(first, kFirst) + padded(kQuantities[i].label, kColumn) +
               cell(summary.means[kEngineReplay][i], kQuantities[i].unit) + "\n";
      first = "";
    }
  }
  return table + "(" + std::to_string(summary.episodes) + " episodes; in brackets " +
         fixedText(100.0 * kConfidence, 0) +
         " % intervals: Wilson for success, Student's t over episodes for divergence)\n";
}

}  // namespace sim2sim
