// SPDX-License-Identifier: BSD-3-Clause
#include "bag/messages.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/parameters.hpp"
#include "sim2sim_protocol/divergence.hpp"
#include "sim2sim_protocol/results/headline.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/table.hpp"
#include "sim2sim_serving/conversions.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace sim2sim {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Divergence kNoDivergence{kNan, kNan};

/// Divergence of two rollouts after `step` control steps; NaN unless both have come that far.
Divergence divergenceAt(const Episode& episode, Mode a, Mode b, int step) {
  const pusht::Rollout& first = episode.rollout(a);
  const pusht::Rollout& second = episode.rollout(b);
  if (step > first.steps() || step > second.steps()) {
    return kNoDivergence;
  }
  const auto k = static_cast<std::size_t>(step);
  return divergence(first.trace().states[k], second.trace().states[k]);
}

/// Divergence of the reference from a tee that never moves.
Divergence nullDivergenceAt(const Episode& episode, int step) {
  const pusht::Rollout& reference = episode.rollout(kReferenceClosed);
  if (step > reference.steps()) {
    return kNoDivergence;
  }
  const std::vector<pusht::WorldState>& states = reference.trace().states;
  return divergence(states.front(), states[static_cast<std::size_t>(step)]);
}

pusht_msgs::SuccessRate toMessage(const SuccessRate& rate, int trials) {
  pusht_msgs::SuccessRate message;
  message.successes = static_cast<std::uint32_t>(rate.successes);
  message.trials = static_cast<std::uint32_t>(trials);
  message.rate = rate.rate;
  const Interval interval = rate.interval.value_or(Interval{kNan, kNan});
  message.low = interval.low;
  message.high = interval.high;
  if (trials > 0) {
    message.text = std::to_string(rate.successes) + "/" + std::to_string(trials) + "  " + shareText(rate);
  }
  return message;
}

pusht_msgs::Mean toMessage(const std::string& name, const char* unit, const Estimate& mean, const std::string& mark) {
  const Interval interval = mean.interval.value_or(Interval{kNan, kNan});
  pusht_msgs::Mean message;
  message.name = name;
  message.unit = unit;
  message.value = mean.value;
  message.low = interval.low;
  message.high = interval.high;
  message.mark = mark;
  if (!std::isnan(mean.value)) {
    message.text = cell(mean, unit) + (mark.empty() ? "" : " ") + mark;
  }
  return message;
}

/// Summary before the first episode has finished.
Summary noSummary(const Protocol& protocol) {
  Summary none;
  none.reference = none.engine = {0, kNan, std::nullopt};
  none.means.resize(protocol.rolloutNames().size());
  return none;
}

}  // namespace

pusht_msgs::Divergence divergenceMessage(const Episode& episode, int step, const ros::Time& stamp) {
  const Divergence replay = divergenceAt(episode, kReferenceClosed, kEngineReplay, step);
  const Divergence closed = divergenceAt(episode, kReferenceClosed, kEngineClosed, step);
  const Divergence null = nullDivergenceAt(episode, step);
  pusht_msgs::Divergence message;
  message.header.stamp = stamp;
  message.episode = static_cast<std::uint64_t>(episode.index());
  message.step = static_cast<std::uint32_t>(step);
  message.replay_position = replay.position;
  message.replay_angle = replay.angle;
  message.closed_position = closed.position;
  message.closed_angle = closed.angle;
  message.null_position = null.position;
  message.null_angle = null.angle;
  return message;
}

pusht_msgs::EpisodeResult toMessage(const Protocol& protocol, const EpisodeResult& episode, const ros::Time& stamp) {
  pusht_msgs::EpisodeResult message;
  message.header.stamp = stamp;
  message.episode = static_cast<std::uint64_t>(episode.index);
  message.seed = episode.seed.value_or(0);
  const std::vector<std::string> modes = protocol.rolloutNames();
  for (std::size_t mode = 0; mode < modes.size(); ++mode) {
    const RolloutResult& result = episode.rollouts.at(mode);
    pusht_msgs::RolloutResult rollout;
    rollout.mode = modes[mode];
    rollout.steps = static_cast<std::uint32_t>(result.steps);
    rollout.success = result.success ? 1 : 0;
    if (result.first_divergence) {
      rollout.parting_step = static_cast<std::uint32_t>(result.first_divergence->step);
      rollout.parting_cause = nameOf(result.first_divergence->cause).name;
      rollout.parting_first = nameOf(result.first_divergence->first);
    }
    if (result.ending) {
      rollout.ending = nameOf(result.ending->ending);
      rollout.still_step = static_cast<std::uint32_t>(result.ending->still_step);
      rollout.pusher_ending = nameOf(result.ending->pusher);
    }
    for (const std::size_t i : protocol.quantityColumns()) {
      pusht_msgs::Quantity quantity;
      quantity.name = kQuantities[i].name;
      quantity.unit = kQuantities[i].unit;
      quantity.value = result.quantities[i];
      rollout.quantities.push_back(quantity);
    }
    message.rollouts.push_back(rollout);
  }
  return message;
}

pusht_msgs::Trace toMessage(const std::string& mode, int episode, const pusht::Trace& trace, const ros::Time& stamp) {
  pusht_msgs::Trace message;
  message.header.stamp = stamp;
  message.episode = static_cast<std::uint64_t>(episode);
  message.mode = mode;
  std::transform(trace.states.begin(), trace.states.end(), std::back_inserter(message.states),
                 [](const pusht::WorldState& state) { return pusht::toMessage(state); });
  return message;
}

pusht_msgs::Summary summaryMessage(const RunConfiguration& configuration, const std::optional<Summary>& finished,
                                   const ros::Time& stamp) {
  const Summary summary = finished ? *finished : noSummary(configuration.protocol);
  pusht_msgs::Summary message;
  message.header.stamp = stamp;
  message.episodes = static_cast<std::uint32_t>(configuration.protocol.episodes);
  message.episodes_finished = static_cast<std::uint32_t>(summary.episodes);
  message.reference = toMessage(summary.reference, summary.episodes);
  message.engine = toMessage(summary.engine, summary.episodes);
  const Outcomes& outcomes = summary.outcomes;
  message.both_succeed = static_cast<std::uint32_t>(outcomes.table.both);
  message.only_reference_succeeds = static_cast<std::uint32_t>(outcomes.table.first_only);
  message.only_engine_succeeds = static_cast<std::uint32_t>(outcomes.table.second_only);
  message.neither_succeeds = static_cast<std::uint32_t>(outcomes.table.neither);
  message.transfer = outcomes.transfer.value_or(kNan);
  const Interval transfer =
      (finished ? transferInterval(configuration.protocol, outcomes) : std::nullopt).value_or(Interval{kNan, kNan});
  message.transfer_low = transfer.low;
  message.transfer_high = transfer.high;
  message.transfer_text = finished ? transferText(configuration, outcomes) : "";
  const std::vector<std::string> rollouts = configuration.protocol.rolloutNames();
  forEachQuantity(configuration.protocol, [&](std::size_t rollout, std::size_t i) {
    message.means.push_back(
        toMessage(metricName(rollouts[rollout], kQuantities[i]), kQuantities[i].unit,
                  finished ? printedMean(summary, rollout, i) : summary.means[rollout][i],
                  finished && rollout == kEngineReplay ? markOf(summary, kQuantities[i].name) : ""));
  });
  message.policy = configuration.policy;
  const Headline headline = headlineOf(configuration, summary.outcomes, summary.endings);
  message.verdict = nameOf(headline.verdict);
  message.caveat = headline.caveat;
  message.headline = headline.text();
  message.reference_stuck = static_cast<std::uint32_t>(summary.endings.reference.of(Ending::kStuck));
  message.engine_stuck = static_cast<std::uint32_t>(summary.endings.engine.of(Ending::kStuck));
  return message;
}

SimulatorRecord recordOf(const pusht_msgs::DescribeResponse& node) {
  const nlohmann::json provenance = pusht::provenanceOf(node);
  SimulatorRecord record{node.name, node.title.empty() ? node.name : node.title};
  for (const pusht_msgs::Parameter& parameter : pusht::withoutTask(node.parameters)) {
    const auto& descriptors = node.parameter_descriptors;
    const auto known = std::find_if(descriptors.begin(), descriptors.end(),
                                    [&](const auto& descriptor) { return descriptor.name == parameter.name; });
    const bool described = known != descriptors.end();
    const pusht::ParameterValue value =
        described && known->type == "text" ? pusht::ParameterValue(parameter.value) : pusht::valueOf(parameter.value);
    record.add(parameter.name, value, described ? known->unit : "",
               described && parameter.value == known->default_value, provenance);
  }
  return record;
}

}  // namespace sim2sim
