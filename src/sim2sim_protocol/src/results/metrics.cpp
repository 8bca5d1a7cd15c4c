// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/metrics.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/json.hpp"

namespace sim2sim {

using nlohmann::json;
using pusht::roundToMicro;

namespace {

bool isOfCourse(std::size_t rollout, std::size_t quantity) {
  return rollout == kEngineReplay && kQuantities[quantity].course_key != nullptr;
}

json outcomes(const Outcomes& outcomes) {
  json keys = {{"both_succeed", outcomes.table.both},
               {"only_reference_succeeds", outcomes.table.first_only},
               {"only_engine_succeeds", outcomes.table.second_only},
               {"neither_succeeds", outcomes.table.neither},
               {"success_difference_p", orNull(outcomes.p)},
               {"success_difference_exact_p", orNull(outcomes.p_exact)}};
  addFigure(keys, "success_difference", "", outcomes.table.difference(), outcomes.difference_interval);
  addFigure(keys, "transfer", "", outcomes.transfer.value_or(kNoFigure), outcomes.transfer_interval);
  return keys;
}

/// The keys of metrics.json on how the failures of a role end.
json endings(const std::string& role, const Endings& endings) {
  json keys = {{role + "_median_still_step", orNull(endings.median_still_step)}};
  for (const Ending ending : {Ending::kStuck, Ending::kMoving, Ending::kLost}) {
    keys[role + "_" + nameOf(ending)] = endings.of(ending);
  }
  for (std::size_t i = 0; i < kPusherEndingNames.size(); ++i) {
    keys[role + "_stuck_pusher_" + kPusherEndingNames[i]] = endings.stuck_pushers[i];
  }
  return keys;
}

/// The keys of metrics.json on how failures end, by role and by the two-by-two table.
json endings(const EndingsOfPairs& both) {
  json keys = endings("reference", both.reference);
  keys.update(endings("engine", both.engine));
  keys.update({{"only_reference_succeeds_engine_stuck", both.only_reference_engine_stuck},
               {"only_engine_succeeds_reference_stuck", both.only_engine_reference_stuck},
               {"neither_succeeds_reference_stuck", both.neither_reference_stuck},
               {"neither_succeeds_engine_stuck", both.neither_engine_stuck}});
  return keys;
}

/// The keys of metrics.json that say how to read a mean divergence.
json baseline(const std::string& name, const std::string& unit, const BaselineComparison& baseline) {
  json keys = {{name + "_episodes", baseline.episodes},
               {name + "_share_of_null", readableJson(baseline.share_of_null)},
               {name + "_share_of_largest", readableJson(baseline.share_of_largest)},
               {name + "_beats_null", orNull(baseline.beatsNull())}};
  addFigure(keys, name + "_median", unit, baseline.median.value, baseline.median.interval);
  addFigure(keys, name + "_minus_null", unit, baseline.minus_null.value, baseline.minus_null.interval);
  addFigure(keys, name + "_over_floor", "", baseline.over_floor, baseline.over_floor_interval);
  return keys;
}

/// The keys of metrics.json of a closed loop in a model variant.
json closedVariant(const std::string& name, const ClosedVariant& variant) {
  const PairTable& table = variant.outcomes.table;
  json keys = {{name + "_successes", variant.success.successes},
               {name + "_success_rate", readableJson(variant.success.rate)},
               {name + "_success_interval", readableJson(variant.success.interval)},
               {name + "_agreement", readableJson((table.both + table.neither) / static_cast<double>(table.pairs()))},
               {name + "_success_difference_adjusted_p", orNull(variant.adjusted_p)}};
  addFigure(keys, name + "_success_difference", "", table.difference(), variant.outcomes.difference_interval);
  return keys;
}

/// Adds the keys of metrics.json of a variance that is split, in `unit`.
void addNoiseSplit(json& keys, const std::string& name, const std::string& unit, const NoiseSplit& split) {
  addFigure(keys, name + "_variance_starts", unit, split.starts.value, split.starts.interval);
  addFigure(keys, name + "_variance_repeats", unit, split.repeats.value, split.repeats.interval);
}

/// The keys of metrics.json that a run with repeats has besides.
json repeats(const Summary& summary) {
  json keys = {{"number_of_starts", summary.outcomes.starts}};
  addNoiseSplit(keys, "reference_success", "", summary.noise->reference);
  addNoiseSplit(keys, "engine_success", "", summary.noise->engine);
  for (std::size_t i = 0; i < kWholeEpisodePairs; ++i) {
    const Quantity& quantity = kQuantities[quantityIndex(kDivergencePairs[i].divergence)];
    addNoiseSplit(keys, metricName(modeName(kEngineReplay), quantity), std::string(quantity.unit) + "2",
                  summary.noise->divergences[i]);
  }
  return keys;
}

/// The keys of metrics.json on success in a simulator.
json success(const std::string& role, const SuccessRate& rate) {
  return {{role + "_success_rate", roundToMicro(rate.rate)},
          {role + "_successes", rate.successes},
          {role + "_success_interval", readableJson(rate.interval)}};
}

/// Adds the keys of metrics.json that compare the engine with the reference.
void addComparison(json& metrics, const RunConfiguration& configuration, const Summary& summary) {
  metrics.update(success("engine", summary.engine));
  metrics.update(outcomes(summary.outcomes));
  metrics.update(endings(summary.endings));
  const std::vector<std::string> rollouts = configuration.protocol.rolloutNames();
  for (std::size_t rollout = kReferenceClosed + 1; rollout < rollouts.size(); ++rollout) {
    for (std::size_t i = 0; i < kDivergencePairs.size(); ++i) {
      const Quantity& quantity = kQuantities[quantityIndex(kDivergencePairs[i].divergence)];
      metrics.update(baseline(metricName(rollouts[rollout], quantity), quantity.unit, summary.baselines[rollout][i]));
    }
  }
  if (!configuration.protocol.model_variants.empty()) {
    for (std::size_t i = 0; i < kDivergencePairs.size(); ++i) {
      const Quantity& quantity = kQuantities[quantityIndex(kDivergencePairs[i].divergence)];
      const BaselineComparison& baseline = summary.baselines[kEngineReplay][i];
      addFigure(metrics, metricName(modeName(kEngineReplay), quantity) + "_over_variants", "", baseline.over_variants,
                baseline.over_variants_interval);
    }
  }
  if (summary.noise) {
    metrics.update(repeats(summary));
  }
  const FirstDivergences& first_divergences = summary.first_divergences;
  metrics["parted"] = first_divergences.parted;
  metrics["median_parting_step"] = orNull(first_divergences.median_step);
  metrics["floor_parted"] = summary.floor ? json(summary.floor->parted) : json();
  metrics["predictability_horizon_step"] = summary.floor ? orNull(summary.floor->median_step) : json();
}

}  // namespace

std::string metricName(const std::string& rollout, const Quantity& quantity) {
  return rollout == modeName(kEngineReplay) && quantity.course_key != nullptr ? quantity.course_key
                                                                              : rollout + "_" + quantity.name;
}

json metrics(const RunConfiguration& configuration, const Summary& summary) {
  json metrics = describe(configuration);
  metrics["episodes"] = summary.episodes;  // fewer than asked for, where it was decided before
  metrics["confidence"] = kConfidence;
  metrics.update(success("reference", summary.reference));
  const std::vector<std::string> rollouts = configuration.protocol.rolloutNames();
  forEachQuantity(configuration.protocol, [&](std::size_t rollout, std::size_t i) {
    const std::string name = metricName(rollouts[rollout], kQuantities[i]);
    const std::string unit = kQuantities[i].unit;
    const Estimate& mean = summary.means[rollout][i];
    addFigure(metrics, name, unit, mean.value, mean.interval);
    if (isOfCourse(rollout, i)) {
      metrics[name + "_" + unit] = printedMean(summary, rollout, i).value;
    }
  });
  for (const ClosedVariant& variant : summary.closed_variants) {
    metrics.update(closedVariant(rollouts[variant.rollout], variant));
  }
  if (configuration.protocol.alone) {
    metrics.update(endings("reference", summary.endings.reference));
    if (summary.noise) {
      metrics["number_of_starts"] = summary.outcomes.starts;
      addNoiseSplit(metrics, "reference_success", "", summary.noise->reference);
    }
  } else {
    addComparison(metrics, configuration, summary);
  }
  if (configuration.reference.name == kCourseReference) {  // as the course calls them
    for (const char* key : {"success_rate", "successes", "success_interval"}) {
      metrics[std::string("mj_") + key] = metrics[std::string("reference_") + key];
    }
  }
  return metrics;
}

json decision(const TransferBet& bet, double share) {
  constexpr std::array kVerdicts = {"undecided", "keeps", "does not keep"};
  return {{"share", share},
          {"verdict", kVerdicts.at(static_cast<std::size_t>(bet.verdict()))},
          {"episodes", orNull(bet.decidedAfter())},
          {"holds_when_stopped", {"transfer_sequence"}},
          {"transfer_sequence", readableJson(transferSequence(bet.counts()))}};
}

Estimate printedMean(const Summary& summary, std::size_t rollout, std::size_t quantity) {
  Estimate mean = summary.means[rollout][quantity];
  if (isOfCourse(rollout, quantity)) {
    mean.value = roundToMicro(mean.value);
  }
  return mean;
}

std::string noteOnNoise(const RunConfiguration& configuration, const json& provenance) {
  if (configuration.protocol.repeats > 1) {
    return "";
  }
  const bool by_policy = !provenance.value(json::json_pointer("/policy/noise"), json()).is_null();
  const bool by_loop = hasNoisyLoop(configuration.reference) || hasNoisyLoop(configuration.engine);
  if (!by_policy && !by_loop) {
    return "";
  }
  return std::string(by_policy && by_loop ? "Policy and loop draw"
                     : by_policy          ? "The policy draws"
                                          : "The loop draws") +
         " random numbers, and each start was played once: how much is chance is not known; see --repeats.";
}

std::string doubtAboutPolicy(const json& metrics, const json& provenance, const Endings& reference) {
  const json hash = provenance.value(json::json_pointer("/policy/sha256"), json());
  const bool is_checkpoint = hash.is_string() && !hash.get_ref<const std::string&>().empty();
  const bool has_other_unit = reference.limitedShare() > kMostLimited;  // the headline says so
  if (!is_checkpoint || has_other_unit || metrics.at("reference_successes").get<int>() > 0) {
    return "";
  }
  const bool at_home = metrics.at("reference_simulator") == kCourseReference;
  return "policy " + metrics.at("policy").get<std::string>() + " never succeeds in the reference" +
         (at_home ? ", the simulator it was trained in" : "") +
         ". It looks untrained or stale: the figures measure the policy, not the gap between the simulators. Whether "
         "it is asked wrongly: audit --policy FILE --demonstrations BAG.";
}

}  // namespace sim2sim
