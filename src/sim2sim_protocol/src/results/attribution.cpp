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

#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/attribution_files.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/run_results.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_protocol/results/text.hpp"
#include "sim2sim_statistics/common.hpp"
#include "starts.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// True/false parameters in which rows differ. Throws InvalidInput if they differ in another parameter.
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

/// Rows by coalition. Throws InvalidInput if one of `wanted` is not among them.
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

/// Random orders of a sweep; empty if it has all combinations.
std::optional<OrderSample> sampleIn(const SweepResults& sweep) {
  if (!sweep.description.contains("permutations")) {
    return std::nullopt;
  }
  try {
    return pusht::asInput([&] { return orderSampleFrom(sweep.description.at("permutations")); });
  } catch (pusht::InvalidInput& error) {
    error.addContext("results " + (sweep.folder / kSweepFile).string());
    throw;
  }
}

/// Results of all rows, which must be of one engine over the same episodes.
std::vector<RunResults> rowsOf(const SweepResults& sweep, const std::function<void()>& go_on) {
  std::vector<RunResults> runs = sweep.readRows(go_on);
  const json name = runs.front().engine().at("name");
  for (const RunResults& run : runs) {
    if (run.engine().at("name") != name) {
      throw pusht::InvalidInput("results " + run.folder.string() + ": must be of the engine of the first row");
    }
    requirePairs(runs.front(), run);
  }
  return runs;
}

/// A kind of gap: its value in an episode of a row, and its names.
struct Measure {
  std::string name;
  std::string title;
  std::string unit;
  std::size_t rollout;
  const char* quantity;    ///< null: success
  const char* null_model;  ///< null: success
};

std::vector<Measure> measuresOf(const Protocol& protocol) {
  std::vector<Measure> measures;
  const auto add = [&](std::size_t rollout, const std::string& how) {
    for (std::size_t i = 0; i < kWholeEpisodePairs; ++i) {
      const DivergencePair& pair = kDivergencePairs[i];
      const Quantity& quantity = kQuantities[quantityIndex(pair.divergence)];
      const bool is_position = i == 0;
      measures.push_back({metricName(protocol.rolloutNames()[rollout], quantity),
                          (is_position ? "position, " : "angle, ") + how, std::string(quantity.unit), rollout,
                          pair.divergence, pair.null_model});
    }
  };
  add(kEngineReplay, "open loop");
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const Probe& probe = probes[i];
    if (probe.world == ProbedWorld::kEngine && probe.reset_every > 0) {
      add(rolloutOfProbe(i),
          "re-anchored every " + std::to_string(probe.reset_every) + (probe.reset_every == 1 ? " step" : " steps"));
    }
  }
  measures.push_back({"lost_success", "success, closed loop", "", kEngineClosed, nullptr, nullptr});
  return measures;
}

/// Gaps of a run by start.
std::vector<double> gapsOf(const RunResults& run, const Measure& measure) {
  return meansByStart(run.protocol, run.episodes, [&](const EpisodeResult& episode) {
    return measure.quantity != nullptr ? episode.rollouts[measure.rollout].at(measure.quantity)
                                       : (episode.rollouts[kReferenceClosed].success ? 1.0 : 0.0) -
                                             (episode.rollouts[kEngineClosed].success ? 1.0 : 0.0);
  });
}

/// Index of the widest floor among the rollouts; empty without floors.
std::optional<std::size_t> floorOf(const Protocol& protocol) {
  std::optional<std::size_t> widest;
  const std::vector<Probe> probes = protocol.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const Probe& probe = probes[i];
    if (probe.world == ProbedWorld::kReference && (!widest || probe.tee_offset > probes[*widest].tee_offset)) {
      widest = i;
    }
  }
  return widest ? std::optional(rolloutOfProbe(*widest)) : std::nullopt;
}

/// Mean gap of a run. For success it has no interval: that would be of another kind.
Estimate meanOfGap(const RunResults& run, const Measure& measure) {
  if (measure.quantity == nullptr) {
    const PairTable table = pairsOf(run.episodes, kReferenceClosed, run.episodes, kEngineClosed);
    return {-table.difference(), std::nullopt};
  }
  return meanOf(run.protocol, meansOfStarts(run.protocol, run.episodes),
                {measure.rollout, quantityIndex(measure.quantity)});
}

/// Attribution of one gap. Without `orders`, also the figures that need all combinations.
AttributedGap attributed(const std::map<Coalition, RunResults>& runs, int switches, const Measure& measure,
                         const std::vector<Order>& orders) {
  std::map<Coalition, std::vector<double>> gaps;
  for (const auto& [on, run] : runs) {
    gaps[on] = gapsOf(run, measure);
  }
  // The null model follows from the reference's trace alone, so it is the same in every row.
  const RunResults& any = runs.begin()->second;
  const std::vector<EpisodeResult> starts = meansOfStarts(any.protocol, any.episodes);
  const std::optional<double> extreme = measure.quantity == nullptr
                                            ? std::nullopt
                                            : extremeOf(starts, {measure.rollout, quantityIndex(measure.quantity)});
  AttributedGap result{
      measure.name, measure.title, measure.unit, averageOf(gaps.begin()->second), averageOf(gaps.rbegin()->second), {}};
  if (orders.empty()) {
    std::vector<std::vector<double>> all;
    std::transform(gaps.begin(), gaps.end(), std::back_inserter(all), [](const auto& entry) { return entry.second; });
    const Game game(switches, all);
    result.shares = shares(game, extreme);
    for (Coalition on = 0; on <= game.all(); ++on) {
      result.gaps.push_back(game.meanGap(on));
    }
    result.alone = alone(game, extreme);
    result.leave_one_out = leaveOneOut(game, extreme);
    result.interactions = interactions(game, extreme);
    result.best_order = bestOrder(game);
    result.staircase = staircase(game, result.best_order);
    result.steps = stepsAlong(game, result.best_order, extreme);
  } else {
    result.shares = sampledShares(orders, gaps, extreme);
  }
  if (measure.quantity != nullptr) {
    result.null_model = meanOf(any.protocol, starts, {measure.rollout, quantityIndex(measure.null_model)});
    if (const std::optional<std::size_t> floor = floorOf(any.protocol); floor && measure.rollout == kEngineReplay) {
      result.floor = meanOf(any.protocol, starts, {*floor, quantityIndex(measure.quantity)});
    }
  }
  return result;
}

}  // namespace

Attribution readAttribution(const fs::path& folder, const fs::path& baseline, const std::function<void()>& go_on) {
  const SweepResults sweep = readWholeSweep(folder, "a sweep over switches");
  std::vector<RunResults> rows = rowsOf(sweep, go_on);
  Attribution result;
  const std::optional<OrderSample> sample = sampleIn(sweep);
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

}  // namespace sim2sim
