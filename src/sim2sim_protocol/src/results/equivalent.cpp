// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/equivalent.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/loop.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/run_results.hpp"
#include "sim2sim_statistics/pairs.hpp"
#include "starts.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

[[noreturn]] void refuseFolder(const fs::path& folder, const std::string& why) {
  throw pusht::InvalidInput("results " + folder.string() + ": " + why);
}

/// A parameter in which a row differs from the reference.
struct ChangedNumber {
  std::string name;
  std::string unit;
  double without;
  double value;
  bool is_integer;
};

/// Value of a parameter of a simulator in metrics.json; a loop that is not there is plain.
json valueOf(const json& simulator, const std::string& name) {
  const json& parameters = simulator.at("parameters");
  if (const auto found = parameters.find(name); found != parameters.end()) {
    return *found;
  }
  const std::string of_loop = pusht::loopParameterOf(name);
  if (of_loop.empty()) {
    return {};
  }
  return std::visit([](const auto& plain) { return json(plain); }, pusht::plainLoop().at(of_loop).value);
}

/// Parameters of `engine` that are not those of `reference`, by name.
std::vector<std::string> differencesOf(const json& engine, const json& reference) {
  std::vector<std::string> names;
  for (const json* simulator : {&engine, &reference}) {
    for (const auto& [name, value] : simulator->at("parameters").items()) {
      const bool is_new = std::find(names.begin(), names.end(), name) == names.end();
      if (is_new && valueOf(engine, name) != valueOf(reference, name)) {
        names.push_back(name);
      }
    }
  }
  return names;
}

/// Whether a row's engine is the reference, as where the values of an error begin with none.
bool isReference(const RunResults& row) {
  const json& reference = row.metrics.at("simulators").at("reference");
  return row.engine().at("name") == reference.at("name") && differencesOf(row.engine(), reference).empty();
}

/// The number in which a row's engine differs from the reference; none if it is another simulator.
std::optional<ChangedNumber> errorIn(const RunResults& row) {
  const json& reference = row.metrics.at("simulators").at("reference");
  const json& engine = row.engine();
  if (engine.at("name") != reference.at("name")) {
    return std::nullopt;
  }
  const std::vector<std::string> names = differencesOf(engine, reference);
  const json value = valueOf(engine, names.front());
  const json without = valueOf(reference, names.front());
  if (names.size() > 1 || !value.is_number() || !without.is_number()) {
    return std::nullopt;
  }
  return ChangedNumber{names.front(), engine.at("units").value(names.front(), ""), without, value,
                       value.is_number_integer() && without.is_number_integer()};
}

/// All rows of a whole sweep over one policy.
std::vector<RunResults> rowsOf(const fs::path& folder, const std::function<void()>& go_on) {
  std::vector<RunResults> rows =
      readWholeSweep(folder, "a sweep over an engine and errors of the reference").readRows(go_on);
  for (const RunResults& row : rows) {
    if (row.metrics.at("policy") != rows.front().metrics.at("policy")) {
      refuseFolder(row.folder, "is of another policy than the first row; must be the same");
    }
    requirePairs(rows.front(), row);
  }
  if (const int starts = rows.front().protocol.starts(); starts < kFewestEpisodes) {
    refuseFolder(folder, "has " + std::to_string(starts) + " starts; must have at least " +
                             std::to_string(kFewestEpisodes) + " for an interval");
  }
  return rows;
}

/// Success of one rollout less that of another, over the same starts.
Surplus surplusOf(double size, const RunResults& more, std::size_t rollout, const RunResults& less,
                  std::size_t other_rollout) {
  if (more.protocol.repeats == 1) {
    const PairTable table = pairsOf(less.episodes, other_rollout, more.episodes, rollout);
    return {size, table.difference(), tangoInterval(table).value()};
  }
  const Difference difference =
      repeatedDifference(pairsByStart(more.protocol, less.episodes, other_rollout, more.episodes, rollout));
  return {size, difference.value, difference.interval.value()};
}

/// Success of the reference less that of the engine of `engine`.
Surplus lostIn(const RunResults& engine) { return surplusOf(0.0, engine, kReferenceClosed, engine, kEngineClosed); }

/// A parameter with its rows on one side of the reference's value.
struct ErrorRows {
  ChangedNumber parameter;
  std::map<double, const RunResults*> by_distance;
};

Equivalent equivalentOf(const ErrorRows& error, const RunResults& engine, const SuccessRate& in_reference) {
  Equivalent equivalent{error.parameter.name, error.parameter.unit, error.parameter.without, {}};
  equivalent.levels.push_back({error.parameter.without, in_reference});
  std::vector<Surplus> surplus = {lostIn(engine)};
  const double direction = error.parameter.value < error.parameter.without ? -1.0 : 1.0;
  for (const auto& [distance, row] : error.by_distance) {
    surplus.push_back(surplusOf(distance, *row, kEngineClosed, engine, kEngineClosed));
    const Surplus gained = surplusOf(distance, *row, kEngineClosed, *row, kReferenceClosed);
    if (gained.interval.low > 0.0 && !equivalent.rises_at) {
      equivalent.rises_at = distance;
    }
    equivalent.levels.push_back(
        {error.parameter.without + direction * distance, summarize(row->protocol, row->episodes).engine});
  }
  equivalent.error = equivalentSize(surplus);
  if (error.parameter.is_integer) {
    equivalent.error.value = std::round(equivalent.error.value);
  }
  return equivalent;
}

}  // namespace

Equivalents readEquivalents(const fs::path& folder, const std::function<void()>& go_on) {
  const std::vector<RunResults> rows = rowsOf(folder, go_on);
  std::vector<const RunResults*> engines;
  std::vector<ErrorRows> errors;
  for (const RunResults& row : rows) {
    if (isReference(row)) {
      continue;
    }
    const std::optional<ChangedNumber> changed = errorIn(row);
    if (!changed) {
      engines.push_back(&row);
      continue;
    }
    const auto known = std::find_if(errors.begin(), errors.end(), [&](const ErrorRows& error) {
      return error.parameter.name == changed->name &&
             (error.parameter.value < changed->without) == (changed->value < changed->without);
    });
    ErrorRows& error = known != errors.end() ? *known : errors.emplace_back(ErrorRows{*changed, {}});
    error.by_distance[std::abs(changed->value - changed->without)] = &row;
  }
  if (engines.empty() || errors.empty()) {
    refuseFolder(folder, std::string("has no ") +
                             (engines.empty() ? "engine but the reference"
                                              : "row in the reference's kind with another value of one number") +
                             "; must have both");
  }
  const Summary first = summarize(rows.front().protocol, rows.front().episodes);
  const json& metrics = rows.front().metrics;
  Equivalents result{titleOf(simulatorFrom(metrics.at("simulators").at("reference"))),
                     metrics.at("policy"),
                     rows.front().protocol.episodes,
                     {}};
  for (const RunResults* engine : engines) {
    go_on();
    EngineEquivalents of_engine{titleOf(simulatorFrom(engine->engine())),
                                summarize(engine->protocol, engine->episodes).engine, lostIn(*engine)};
    for (const ErrorRows& error : errors) {
      of_engine.equivalents.push_back(equivalentOf(error, *engine, first.reference));
    }
    result.engines.push_back(std::move(of_engine));
  }
  return result;
}

}  // namespace sim2sim
