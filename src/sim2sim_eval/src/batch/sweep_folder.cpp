// SPDX-License-Identifier: BSD-3-Clause
#include "batch/sweep_folder.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "pusht_task/files.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/difference.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/statistics.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kTablesWritten = 20;  // in the course of a sweep, about

/// A cell of sweep.csv.
std::string csvCell(const json& value) {
  return value.is_number_float() ? pusht::shortestText(value.get<double>())
         : value.is_string()     ? csvText(value.get<std::string>())
         : value.is_null()       ? ""
                                 : value.dump();
}

using Columns = std::vector<std::pair<std::string, json>>;

/// Names of columns that tell the rows apart: policy, kind of reference and kind of engine, where there are several,
/// and all parameters of a row.
std::vector<std::string> parameterNames(const std::vector<json>& rows) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      names.push_back(name);
    }
  };
  for (const char* name : {"policy", "reference_simulator", "engine_simulator"}) {
    if (std::any_of(rows.begin(), rows.end(), [&](const json& row) { return row.at(name) != rows.front().at(name); })) {
      names.emplace_back(name);
    }
  }
  for (const json& row : rows) {
    for (const auto& [name, value] : row.at("knobs").items()) {
      add(name);
    }
  }
  return names;
}

/// The columns of sweep.csv after the row's number: each a name and a value of the row's metrics. `reference` begins
/// the names of the reference's.
Columns columns(const json& metrics, const std::vector<std::string>& parameters, const std::string& reference) {
  Columns columns;
  for (const std::string& name : parameters) {
    columns.emplace_back(name, metrics.contains(name) ? metrics.at(name) : metrics.at("knobs").value(name, json()));
  }
  columns.emplace_back("episodes", metrics.at("episodes"));
  const auto add = [&](const std::string& name, const std::string& interval = "") {
    columns.emplace_back(name, metrics.at(name));
    if (!interval.empty()) {
      const json& bounds = metrics.at(interval);
      columns.emplace_back(name + "_low", bounds.is_null() ? json() : bounds.at(0));
      columns.emplace_back(name + "_high", bounds.is_null() ? json() : bounds.at(1));
    }
  };
  add(reference + "_successes");
  add(reference + "_success_rate", reference + "_success_interval");
  add("engine_successes");
  add("engine_success_rate", "engine_success_interval");
  add("success_difference", "success_difference_interval");
  add("success_difference_p");
  add("transfer", "transfer_interval");
  const Protocol protocol = protocolFrom(metrics);
  const std::vector<std::string> rollouts = protocol.rolloutNames();
  forEachQuantity(protocol, [&](std::size_t rollout, std::size_t i) {
    const std::string name = metricName(rollouts[rollout], kQuantities[i]);
    add(name + "_" + kQuantities[i].unit, name + "_interval_" + kQuantities[i].unit);
  });
  for (const DivergencePair& pair : kDivergencePairs) {
    const Quantity& quantity = kQuantities[quantityIndex(pair.divergence)];
    const std::string unit = quantity.unit;
    for (std::size_t rollout = kReferenceClosed + 1; rollout < rollouts.size(); ++rollout) {
      const std::string name = metricName(rollouts[rollout], quantity);
      for (const char* figure : {"_median_", "_minus_null_"}) {
        std::string interval = name + figure;
        const std::string value = interval + unit;
        add(value, interval.append("interval_").append(unit));
      }
      add(name + "_episodes");
      add(name + "_share_of_null");
      add(name + "_over_floor", name + "_over_floor_interval");
      add(name + "_beats_null");
      add(name + "_share_of_largest");
      if (metrics.contains(name + "_over_variants")) {
        add(name + "_over_variants", name + "_over_variants_interval");
      }
    }
  }
  for (const std::string& rollout : rollouts) {
    if (metrics.contains(rollout + "_success_difference")) {  // a closed loop in a model variant
      add(rollout + "_success_rate", rollout + "_success_interval");
      add(rollout + "_success_difference", rollout + "_success_difference_interval");
    }
  }
  add("parted");
  add("median_parting_step");
  add("floor_parted");
  add("predictability_horizon_step");
  return columns;
}

std::string sweepCsv(const std::vector<json>& rows) {
  const std::vector<std::string> parameters = parameterNames(rows);
  const bool only_mujoco =
      std::all_of(rows.begin(), rows.end(), [](const json& row) { return row.contains("mj_successes"); });
  std::string csv;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::string head = "row";
    std::string line = rows[i].at("row").dump();
    for (const auto& [name, value] : columns(rows[i], parameters, only_mujoco ? "mj" : "reference")) {
      head.append(",").append(name);
      line.append(",").append(csvCell(value));
    }
    csv.append(i == 0 ? head + "\n" : "").append(line).append("\n");
  }
  return csv;
}

}  // namespace

std::vector<Input> inputsOf(const fs::path& shard) {
  return {{"shard", shard / kSweepFile}, {"shard", shard / kProvenanceFile}, {"shard", rowsFolder(shard)}};
}

std::string differenceOf(const SweepResults& found, const json& description, const json& provenance) {
  constexpr const char* kMustBe = ", must be ";
  std::string difference = firstDifference(found.description, description, kMustBe);
  const json origin = found.provenance();
  for (const char* key : {"format", "code"}) {
    if (difference.empty()) {
      difference = firstDifference({{key, origin.value(key, json())}}, {{key, provenance.value(key, json())}}, kMustBe);
    }
  }
  return difference;
}

SweepRow::SweepRow(const RunConfiguration& configuration, std::vector<EpisodeResult> results)
    : episodes(std::move(results)),
      summary(summarize(configuration.protocol, episodes)),
      metrics(sim2sim::metrics(configuration, summary)) {}

std::optional<SweepRow> readRow(const fs::path& folder, std::size_t index, const RunConfiguration& configuration) {
  const fs::path path = rowFolder(folder, index);
  std::error_code ignored;
  if (!fs::exists(path / kMetricsFile, ignored)) {  // it is written last
    return std::nullopt;
  }
  const auto refuse = [&](const char* file, const std::string& why) {
    throw pusht::BadDependency("row " + (path / file).string() + ": " + why + "; delete the row to have it run again");
  };
  std::vector<EpisodeResult> episodes;
  try {
    episodes = episodesFromCsv(configuration.protocol, pusht::readFile(path / kEpisodesFile, "row"));
  } catch (const pusht::InvalidInput& error) {
    refuse(kEpisodesFile, error.what());
  }
  const Protocol& protocol = configuration.protocol;
  bool as_asked = static_cast<int>(episodes.size()) == protocol.episodes;
  for (std::size_t i = 0; as_asked && i < episodes.size(); ++i) {
    const int episode = protocol.first_episode + static_cast<int>(i);
    as_asked = episodes[i].index == episode && episodes[i].seed == protocol.spawnSeed(episode);
  }
  if (!as_asked) {
    refuse(kEpisodesFile,
           "must hold episodes " + std::to_string(protocol.first_episode) + " to " +
               std::to_string(protocol.lastEpisode()) +
               (protocol.initial_states ? " of the given starts" : " of seed " + std::to_string(protocol.seed)));
  }
  SweepRow row(configuration, std::move(episodes));
  if (pusht::readFile(path / kMetricsFile, "row") != jsonText(row.metrics)) {
    refuse(kMetricsFile, "does not agree with its episodes");
  }
  return row;
}

SweepFolder::SweepFolder(fs::path path, bool overwrite, std::string command)
    : folder_(std::move(path), std::move(command), Results::kSweep), overwrite_(overwrite) {}

void SweepFolder::begin(const json& description, const json& provenance) {
  description_ = description;
  folder_.open();
  std::error_code error;
  if (!overwrite_ && fs::exists(path() / kSweepFile, error)) {
    const std::string difference = differenceOf(readSweep(path()), description, provenance);
    if (!difference.empty()) {
      throw pusht::InvalidInput("out " + path().string() + ": holds another sweep (" + difference +
                                "); name another folder, or replace it with --overwrite");
    }
    writeStatus(pusht::ExitCode::kRuntimeFault, kUnderWay);
    folder_.removeLeftovers();
    return;
  }
  folder_.refuseResults(overwrite_);
  writeStatus(pusht::ExitCode::kRuntimeFault, kUnderWay);
  folder_.removeResults();
  pusht::writeFile(path() / kProvenanceFile, jsonText(provenance));
  writeTables();
}

Journal SweepFolder::journal(std::size_t index, const RunConfiguration& configuration) const {
  return {createRow(index) / kJournalFile, configuration.protocol, {{"configuration", describe(configuration)}}};
}

fs::path SweepFolder::createRow(std::size_t index) const {
  fs::path folder = rowFolder(path(), index);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw pusht::RuntimeFault("cannot create " + folder.string() + ": " + error.message());
  }
  return folder;
}

void SweepFolder::keep(std::size_t index, const RunConfiguration& configuration, const SweepRow& row) {
  const fs::path folder = createRow(index);
  pusht::writeFile(folder / kEpisodesFile, episodesCsv(configuration.protocol, row.episodes));
  pusht::writeFile(folder / kStatisticsFile, jsonText(statistics(configuration, row.episodes)));
  pusht::writeFile(folder / kMetricsFile, jsonText(row.metrics));
  resume(index, row.metrics);
  writeStatus(pusht::ExitCode::kRuntimeFault, kUnderWay);
}

void SweepFolder::resume(std::size_t index, json row) {
  std::error_code ignored;
  fs::remove(rowFolder(path(), index) / kJournalFile, ignored);  // the row has all that it holds
  row["row"] = index;
  rows_.push_back(std::move(row));
  if (rows_.size() % (description_.at("rows").size() / kTablesWritten + 1) == 0) {
    writeTables();
  }
}

void SweepFolder::refuse(const RunStatus& status) {
  folder_.open();
  if (!folder_.holdsResults()) {
    writeStatus(status.exit_code, status.reason);
  }
}

void SweepFolder::finish(pusht::ExitCode code, const std::string& reason) {
  writeTables();
  writeStatus(code, reason);
}

void SweepFolder::writeStatus(pusht::ExitCode code, const std::string& reason) const {
  pusht::writeFile(path() / kStatusFile, jsonText({{"format", kStatusFormat},
                                                   {"exit_code", static_cast<int>(code)},
                                                   {"reason", reason},
                                                   {"rows_finished", rows_.size()},
                                                   {"rows", description_.at("rows").size()}}));
}

void SweepFolder::writeTables() const {
  pusht::writeFile(path() / kSweepTable, sweepCsv(rows_));
  pusht::writeFile(path() / kSweepFile, jsonText({{"sweep", description_}, {"rows", rows_}}));
}

std::string rowText(std::size_t index, std::size_t rows) {
  return "row " + std::to_string(index) + " of 0 to " + std::to_string(rows - 1);
}

}  // namespace sim2sim
