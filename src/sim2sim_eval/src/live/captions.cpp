// SPDX-License-Identifier: BSD-3-Clause
#include "live/captions.hpp"

#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/task.hpp"
#include "sim2sim_protocol/ending.hpp"
#include "sim2sim_protocol/results/table.hpp"
#include "sim2sim_protocol/results/text.hpp"
#include "sim2sim_serving/world_markers.hpp"

namespace sim2sim {

using pusht::fixedText;

namespace {

Result successResult(const SuccessRate& rate, int episodes) {
  return {
      "success " + std::to_string(rate.successes) + "/" + std::to_string(episodes) + " = " + fixedText(rate.rate, 2),
      rate.interval ? "95% interval " + bracketed(*rate.interval, 2) : ""};
}

Result divergenceResult(const Summary& summary) {
  const Estimate& position = summary.mean(kEngineReplay, "mean_position_divergence");
  const Estimate& angle = summary.mean(kEngineReplay, "mean_angle_divergence");
  Result result{"divergence " + fixedText(position.value, 3) + " m" + doubtMark(summary, "mean_position_divergence") +
                    ", " + fixedText(angle.value, 2) + " rad" + doubtMark(summary, "mean_angle_divergence"),
                ""};
  if (position.interval && angle.interval) {
    result.certainty =
        "95% intervals " + bracketed(*position.interval, 3) + " m, " + bracketed(*angle.interval, 2) + " rad";
  }
  return result;
}

}  // namespace

Result resultOf(Mode mode, const Summary& summary) {
  switch (mode) {
    case kReferenceClosed:
      return successResult(summary.reference, summary.episodes);
    case kEngineClosed:
      return successResult(summary.engine, summary.episodes);
    default:
      return divergenceResult(summary);
  }
}

std::string titleOf(Mode mode, const RunConfiguration& run) {
  return mode == kReferenceClosed ? run.reference.title + ", the reference" : run.engine.title;
}

std::string subtitleOf(Mode mode, const RunConfiguration& run) {
  switch (mode) {
    case kReferenceClosed:
      return "policy " + run.policy;
    case kEngineClosed:
      return "same policy";
    default:
      return "same actions as " + (run.reference.title == run.engine.title ? "the reference" : run.reference.title);
  }
}

std::vector<std::string> changedParameters(const SimulatorRecord& simulator, std::size_t lines, std::size_t length) {
  constexpr std::size_t kRest = 14;  // bytes of ", and 100 more"
  std::vector<std::string> text;
  for (std::size_t i = 0; i < simulator.changed.size(); ++i) {
    const std::string& name = simulator.changed[i];
    const nlohmann::ordered_json& value = simulator.parameters.at(name);
    const std::string parameter =
        pusht::fitted(name + " " + (value.is_string() ? value.get<std::string>() : value.dump()), length - kRest);
    const bool fits = !text.empty() && text.back().size() + 2 + parameter.size() + kRest <= length;
    if (fits) {
      text.back() += ", " + parameter;
    } else if (text.size() < lines) {
      text.push_back(parameter);
    } else {
      text.back() += ", and " + std::to_string(simulator.changed.size() - i) + " more";
      break;
    }
  }
  return text;
}

std::string statusOf(Mode mode, const Episode& episode) {
  const pusht::Rollout& rollout = episode.rollout(mode);
  const std::string off = pusht::distanceText(rollout.trace().states.back(), rollout.task());
  if (rollout.success()) {
    return "success" + (mode == kEngineReplay ? "" : " after " + secondsText(rollout.steps())) + " (" + off + ")";
  }
  const bool ended = episode.finished();
  const std::optional<RolloutEnding> end = ended ? std::optional(endingOf(rollout)) : std::nullopt;
  const std::string where = isOffTable(rollout.trace().states.back(), rollout.task()) ? "off the table: "
                            : !ended                                                  ? ""
                            : mode != kEngineReplay && end->ending == Ending::kStuck
                                ? "stuck since " + secondsText(end->still_step) + ": "
                                : "no success: ";
  return where + off + (rollout.task().success.coverage ? " of the target" : " target");
}

std::string secondsText(int steps) { return fixedText(steps * pusht::kControlStep, 1) + " s"; }

std::string firstDivergenceText(const std::optional<FirstDivergence>& first_divergence) {
  if (!first_divergence) {
    return "";
  }
  return "parts at " + secondsText(first_divergence->step) + ": " + nameOf(first_divergence->cause).label + ", " +
         nameOf(first_divergence->first) + " first";
}

}  // namespace sim2sim
