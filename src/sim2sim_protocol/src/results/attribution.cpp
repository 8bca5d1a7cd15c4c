// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/attribution.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <sstream>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/contrast.hpp"
#include "sim2sim_protocol/results/output_folder.hpp"
#include "sim2sim_protocol/results/report.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kAttributionFormat = 1;  // of the JSON

/// The true/false parameters in which rows differ.
std::vector<std::string> switchesIn(const std::vector<RunResults>& runs) {
  const json first = runs.front().engine();
  std::vector<std::string> switches;
  for (const auto& [name, value] : first.at("parameters").items()) {
    const auto differing = std::find_if(runs.begin(), runs.end(), [&, &name = name, &value = value](const auto& run) {
      return run.engine().at("parameters").value(name, json()) != value;
    });
    if (differing == runs.end()) {
      continue;
    }
    if (!value.is_boolean()) {
      throw pusht::InvalidInput("results " + differing->folder.string() + ": differs from the first row in " + name +
                                ": only true/false parameters may vary");
    }
    switches.push_back(name);
  }
  return switches;
}

Coalition coalitionOf(const RunResults& run, const std::vector<std::string>& switches) {
  const json parameters = run.engine().at("parameters");
  Coalition on = 0;
  for (std::size_t i = 0; i < switches.size(); ++i) {
    const json value = parameters.value(switches[i], json());
    if (!value.is_boolean()) {
      throw pusht::InvalidInput("results " + run.folder.string() + ": must have a true/false parameter " + switches[i]);
    }
    on |= static_cast<Coalition>(value.get<bool>() ? 1 : 0) << i;
  }
  return on;
}

std::string textOf(Coalition on, const std::vector<std::string>& switches) {
  std::vector<std::string> values;
  for (std::size_t i = 0; i < switches.size(); ++i) {
    values.push_back(switches[i] + ((on >> i & 1U) != 0 ? " true" : " false"));
  }
  return pusht::joined(values);
}

/// All rows, by coalition. Throws InvalidInput if one of `wanted` is not among them.
std::map<Coalition, RunResults> byCoalition(std::vector<RunResults> runs, const std::vector<std::string>& switches,
                                            const std::vector<Coalition>& wanted) {
  std::map<Coalition, RunResults> ordered;
  for (RunResults& run : runs) {
    const Coalition on = coalitionOf(run, switches);
    ordered[on] = std::move(run);
  }
  for (const Coalition on : wanted) {
    if (ordered.count(on) == 0) {
      throw pusht::InvalidInput("the sweep must have every combination of its switches, but " + textOf(on, switches) +
                                " is not there");
    }
  }
  return ordered;
}

std::vector<Coalition> allOf(std::size_t switches) {
  std::vector<Coalition> all(std::size_t{1} << switches);
  std::iota(all.begin(), all.end(), Coalition{0});
  return all;
}

/// None if the sweep in `folder` is not of random orders.
std::optional<OrderSample> sampleIn(const fs::path& folder) {
  const json sweep = json::parse(pusht::readFile(folder / kSweepFile, "results"), nullptr, false);
  const json::json_pointer place("/sweep/permutations");
  if (!sweep.is_object() || !sweep.contains(place)) {
    return std::nullopt;
  }
  try {
    return pusht::asInput([&] { return orderSampleFrom(sweep.at(place)); });
  } catch (pusht::InvalidInput& error) {
    error.addContext("results " + (folder / kSweepFile).string());
    throw;
  }
}

std::vector<RunResults> read(const fs::path& folder, const std::function<void()>& go_on) {
  if (std::error_code ignored; fs::exists(folder / kMetricsFile, ignored)) {
    throw pusht::InvalidInput("results " + folder.string() + ": is a run; a sweep over switches is needed");
  }
  const std::vector<fs::path> rows = runsIn(folder);
  const json sweep = json::parse(pusht::readFile(folder / kSweepFile, "results"), nullptr, false);
  if (const json::json_pointer shard("/sweep/shard"); sweep.is_object() && sweep.contains(shard)) {
    throw pusht::InvalidInput("results " + folder.string() + ": is shard " + sweep.at(shard).dump() +
                              " of a sweep; merge the shards first");
  }
  std::vector<RunResults> runs;
  for (const fs::path& run : rows) {
    go_on();
    runs.push_back(readResults(run));
  }
  const json name = runs.front().engine().at("name");
  for (const RunResults& run : runs) {
    if (run.engine().at("name") != name) {
      throw pusht::InvalidInput("results " + run.folder.string() + ": must be of the engine of the first row");
    }
    requirePairs(runs.front(), run);
  }
  return runs;
}

/// One gap: what it is of an episode of a row, and how it is called.
struct Measure {
  std::string name;
  std::string title;
  std::string unit;
  std::size_t rollout;
  const char* quantity;    ///< none: success
  const char* null_model;  ///< likewise
};

std::vector<Measure> measuresOf(const Protocol& protocol) {
  std::vector<Measure> measures;
  const auto add = [&](std::size_t rollout, const std::string& how) {
    for (const DivergencePair& pair : kDivergencePairs) {
      const Quantity& quantity = kQuantities[quantityIndex(pair.divergence)];
      const bool is_position = &pair == kDivergencePairs.data();
      measures.push_back({metricName(protocol.rolloutNames()[rollout], quantity),
                          (is_position ? "position, " : "angle, ") + how, std::string(quantity.unit), rollout,
                          pair.divergence, pair.null_model});
    }
  };
  add(kEngineReplay, "open loop");
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const Probe& probe = probes[i];
    if (probe.role == Role::kEngine && probe.anchor_every > 0) {
      add(kModeCount + i,
          "re-anchored every " + std::to_string(probe.anchor_every) + (probe.anchor_every == 1 ? " step" : " steps"));
    }
  }
  measures.push_back({"lost_success", "success, closed loop", "", kEngineClosed, nullptr, nullptr});
  return measures;
}

std::vector<double> gapsOf(const RunResults& run, const Measure& measure) {
  std::vector<double> gaps;
  gaps.reserve(run.episodes.size());
  for (const EpisodeResult& episode : run.episodes) {
    if (measure.quantity != nullptr) {
      gaps.push_back(episode.rollouts[measure.rollout].at(measure.quantity));
    } else {
      gaps.push_back((episode.rollouts[kReferenceClosed].success ? 1.0 : 0.0) -
                     (episode.rollouts[kEngineClosed].success ? 1.0 : 0.0));
    }
  }
  return gaps;
}

/// The widest floor, as a place among the rollouts; none if there is none.
std::optional<std::size_t> floorOf(const Protocol& protocol) {
  std::optional<std::size_t> widest;
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const Probe& probe = probes[i];
    if (probe.role == Role::kReference && (!widest || probe.start_offset > probes[*widest - kModeCount].start_offset)) {
      widest = kModeCount + i;
    }
  }
  return widest;
}

/// Its interval is none for success, which has one of another kind.
Estimate meanOfGap(const RunResults& run, const Measure& measure) {
  if (measure.quantity == nullptr) {
    const PairTable table = pairsOf(run.episodes, kReferenceClosed, run.episodes, kEngineClosed);
    return {-table.difference(), std::nullopt};
  }
  const std::size_t quantity = quantityIndex(measure.quantity);
  return meanOf(samplesOf(run.episodes, measure.rollout, quantity), kQuantities[quantity]);
}

/// With all that needs all combinations, if they are there.
AttributedGap attributed(const std::map<Coalition, RunResults>& runs, int switches, const Measure& measure,
                         const std::vector<Order>& orders) {
  std::map<Coalition, std::vector<double>> gaps;
  for (const auto& [on, run] : runs) {
    gaps[on] = gapsOf(run, measure);
  }
  const auto mean = [](const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  };
  AttributedGap result{
      measure.name, measure.title, measure.unit, mean(gaps.begin()->second), mean(gaps.rbegin()->second), {}};
  if (orders.empty()) {
    std::vector<std::vector<double>> all;
    std::transform(gaps.begin(), gaps.end(), std::back_inserter(all), [](const auto& entry) { return entry.second; });
    const Game game(switches, all);
    result.shares = shares(game);
    for (Coalition on = 0; on <= game.all(); ++on) {
      result.gaps.push_back(game.meanGap(on));
    }
    result.alone = alone(game);
    result.leave_one_out = leaveOneOut(game);
    result.interactions = interactions(game);
    result.best_order = bestOrder(game);
    result.staircase = staircase(game, result.best_order);
  } else {
    result.shares = sampledShares(orders, gaps);
  }
  if (measure.quantity != nullptr) {
    const RunResults& any = runs.begin()->second;
    const std::size_t quantity = quantityIndex(measure.quantity);
    const std::size_t null_model = quantityIndex(measure.null_model);
    result.null_model = meanOf(samplesOf(any.episodes, measure.rollout, null_model), kQuantities[null_model]);
    if (const std::optional<std::size_t> floor = floorOf(any.protocol); floor && measure.rollout == kEngineReplay) {
      result.floor = meanOf(samplesOf(any.episodes, *floor, quantity), kQuantities[quantity]);
    }
  }
  return result;
}

json readableJson(const std::optional<Interval>& interval) {
  return interval ? json{readable(interval->low), readable(interval->high)} : json();
}

json readableJson(double value) { return std::isfinite(value) ? json(readable(value)) : json(); }

json readableJson(const Difference& difference) {
  return {{"value", readableJson(difference.value)}, {"interval", readableJson(difference.interval)}};
}

json readableJson(const Estimate& estimate) {
  return {{"value", readableJson(estimate.value)}, {"interval", readableJson(estimate.interval)}};
}

json readableAll(const std::vector<double>& values) {
  json result = json::array();
  std::transform(values.begin(), values.end(), std::back_inserter(result), readable);
  return result;
}

json readableJson(const AttributedGap& gap, const std::vector<std::string>& switches) {
  json by_switch = json::object();
  for (std::size_t i = 0; i < switches.size(); ++i) {
    const Share& share = gap.shares[i];
    by_switch[switches[i]] = {{"share", readableJson(share.value)},
                              {"share_interval", readableJson(share.interval)},
                              {"part", readableJson(share.part)},
                              {"part_interval", readableJson(share.part_interval)}};
    if (!gap.gaps.empty()) {
      by_switch[switches[i]]["alone"] = readableJson(gap.alone[i]);
      by_switch[switches[i]]["leave_one_out"] = readableJson(gap.leave_one_out[i]);
    }
  }
  json pairs = json::array();
  for (const Interaction& interaction : gap.interactions) {
    json pair = readableJson(interaction.value);
    pair["switches"] = {switches[static_cast<std::size_t>(interaction.first)],
                        switches[static_cast<std::size_t>(interaction.second)]};
    pairs.push_back(pair);
  }
  json order = json::array();
  for (const int player : gap.best_order) {
    order.push_back(switches[static_cast<std::size_t>(player)]);
  }
  return {{"title", gap.title},
          {"unit", gap.unit},
          {"all_off", readable(gap.all_off)},
          {"all_on", readable(gap.all_on)},
          {"gaps", readableAll(gap.gaps)},
          {"switches", by_switch},
          {"interactions", pairs},
          {"best_order", order},
          {"staircase", readableAll(gap.staircase)},
          {"null_model", readableJson(gap.null_model)},
          {"baseline", readableJson(gap.baseline)},
          {"floor", readableJson(gap.floor)}};
}

constexpr std::size_t kNameWidth = 18;
constexpr std::size_t kCellWidth = 42;

/// "+0.0198 m [0.0149, 0.0247]  25 %"
std::string shareCell(const Share& share, int digits) {
  const std::string part = std::isfinite(share.part) ? "  " + percent(share.part) : "";
  return signedText(share.value, share.interval, "", digits) + part;
}

}  // namespace

json toJson(const OrderSample& sample) {
  return {{"switches", sample.players}, {"orders", sample.orders}, {"seed", sample.seed}};
}

OrderSample orderSampleFrom(const json& json) {
  try {
    return {json.at("switches").get<std::vector<std::string>>(), json.at("orders").get<int>(),
            json.at("seed").get<std::uint32_t>()};
  } catch (const nlohmann::json::exception& error) {
    throw pusht::InvalidInput(std::string("permutations: must have switches, orders and seed: ") + error.what());
  }
}

Attribution attribute(const fs::path& folder, const fs::path& baseline, const std::function<void()>& go_on) {
  std::vector<RunResults> rows = read(folder, go_on);
  Attribution result;
  const std::optional<OrderSample> sample = sampleIn(folder);
  const std::vector<Order> orders = sample ? sample->draw() : std::vector<Order>();
  result.orders = static_cast<int>(orders.size());
  result.switches = sample ? sample->players : switchesIn(rows);
  if (result.switches.empty()) {
    throw pusht::InvalidInput("results " + folder.string() +
                              ": must be a sweep over true/false parameters of an engine");
  }
  if (!sample && result.switches.size() > static_cast<std::size_t>(kMostPlayers)) {
    throw pusht::InvalidInput("results " + folder.string() + ": must be a sweep over at most " +
                              std::to_string(kMostPlayers) + " true/false parameters, or over permutations of them");
  }
  std::map<Coalition, RunResults> runs;
  try {
    const std::vector<Coalition> coalitions =
        pusht::asInput([&] { return sample ? coalitionsAlong(orders) : allOf(result.switches.size()); });
    runs = byCoalition(std::move(rows), result.switches, coalitions);
  } catch (pusht::InvalidInput& error) {
    error.addContext("results " + folder.string());
    throw;
  }
  const RunResults& any = runs.begin()->second;
  const json& metrics = any.metrics;
  result.reference = metrics.at("simulators").at("reference").at("title").get<std::string>();
  result.engine = metrics.at("simulators").at("engine").at("title").get<std::string>();
  result.policy = metrics.at("policy").get<std::string>();
  result.episodes = any.protocol.episodes;
  result.combinations = runs.size();
  std::optional<RunResults> beside;
  if (!baseline.empty()) {
    beside = readResults(baseline);
    requirePairs(any, *beside);
    result.baseline = beside->title();
  }
  for (const Measure& measure : measuresOf(any.protocol)) {
    go_on();
    result.gaps.push_back(attributed(runs, static_cast<int>(result.switches.size()), measure, orders));
    if (beside) {
      result.gaps.back().baseline = meanOfGap(*beside, measure);
    }
  }
  return result;
}

json toJson(const Attribution& attribution) {
  json gaps = json::object();
  for (const AttributedGap& gap : attribution.gaps) {
    gaps[gap.name] = readableJson(gap, attribution.switches);
  }
  json names = json::array();
  for (const AttributedGap& gap : attribution.gaps) {
    names.push_back(gap.name);
  }
  return {{"format", kAttributionFormat},
          {"confidence", kConfidence},
          {"reference", attribution.reference},
          {"engine", attribution.engine},
          {"policy", attribution.policy},
          {"episodes", attribution.episodes},
          {"combinations", attribution.combinations},
          {"orders", attribution.orders},
          {"baseline", attribution.baseline},
          {"switches", attribution.switches},
          {"order", names},
          {"gaps", gaps}};
}

std::string toCsv(const Attribution& attribution) {
  std::ostringstream csv;
  csv << "gap,unit,switch,share,share_low,share_high,part,part_low,part_high,alone,leave_one_out\n";
  const auto number = [](double value) { return std::isfinite(value) ? pusht::shortestText(readable(value)) : ""; };
  const auto ends = [&](const std::optional<Interval>& interval) {
    return interval ? number(interval->low) + "," + number(interval->high) : std::string(",");
  };
  for (const AttributedGap& gap : attribution.gaps) {
    for (std::size_t i = 0; i < attribution.switches.size(); ++i) {
      const Share& share = gap.shares[i];
      csv << gap.name << ',' << gap.unit << ',' << attribution.switches[i] << ',' << number(share.value) << ','
          << ends(share.interval) << ',' << number(share.part) << ',' << ends(share.part_interval) << ','
          << (gap.gaps.empty() ? "," : number(gap.alone[i].value) + "," + number(gap.leave_one_out[i].value)) << '\n';
    }
  }
  return csv.str();
}

std::string table(const Attribution& attribution) {
  constexpr int kDigits = 4;
  std::string text = attribution.engine + " against " + attribution.reference + ", policy " + attribution.policy +
                     ", " + std::to_string(attribution.episodes) + " episodes, " +
                     std::to_string(attribution.combinations) + " combinations" +
                     (attribution.orders > 0 ? " along " + std::to_string(attribution.orders) + " random orders" : "") +
                     "\n";
  // Position and angle of the same rollouts stand side by side.
  for (std::size_t first = 0; first < attribution.gaps.size(); first += 2) {
    const auto begin = attribution.gaps.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end =
        attribution.gaps.begin() + static_cast<std::ptrdiff_t>(std::min(first + 2, attribution.gaps.size()));
    const auto line = [&](const std::string& name, const auto& cell) {
      text += "  " + padded(name, kNameWidth);
      for (auto gap = begin; gap != end; ++gap) {
        text += padded(cell(*gap), kCellWidth);
      }
      text.erase(text.find_last_not_of(' ') + 1);
      text += '\n';
    };
    const auto plain = [](double value) { return pusht::fixedText(readable(value), kDigits); };
    line("", [](const AttributedGap& gap) { return gap.title + (gap.unit.empty() ? "" : " [" + gap.unit + "]"); });
    if (std::isfinite(begin->null_model.value)) {
      line("tee never moves", [&](const AttributedGap& gap) { return plain(gap.null_model.value); });
    }
    if (!attribution.baseline.empty()) {
      line("baseline", [&](const AttributedGap& gap) { return plain(gap.baseline.value); });
    }
    line("all off", [&](const AttributedGap& gap) { return plain(gap.all_off); });
    for (std::size_t i = 0; i < attribution.switches.size(); ++i) {
      line(attribution.switches[i], [&](const AttributedGap& gap) { return shareCell(gap.shares[i], kDigits); });
    }
    line("all on", [&](const AttributedGap& gap) { return plain(gap.all_on); });
  }
  if (!attribution.baseline.empty()) {
    text += "(baseline: " + attribution.baseline + ")\n";
  }
  return text + "(each line: how much of the gap the switch closes, averaged over all orders of switching on, with " +
         pusht::fixedText(100.0 * kConfidence, 0) +
         " % interval and share of the whole;\nsuccess: reference rate minus engine rate." +
         (attribution.episodes < kFewestPairs ? " Below " + std::to_string(kFewestPairs) + " episodes no intervals"
                                              : "") +
         ")\n";
}

}  // namespace sim2sim
