// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/endings.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sim2sim_protocol/results/json.hpp"

namespace sim2sim {
namespace {

bool isStuck(const RolloutResult& rollout) { return rollout.ending && rollout.ending->ending == Ending::kStuck; }

}  // namespace

Endings endingsOf(const std::vector<EpisodeResult>& episodes, std::size_t rollout) {
  Endings endings;
  std::vector<int> still_steps;
  for (const EpisodeResult& episode : episodes) {
    const RolloutResult& result = episode.rollouts[rollout];
    if (result.limited_commands) {
      endings.commands += result.steps;
      endings.limited_commands += *result.limited_commands;
    }
    const std::optional<RolloutEnding>& end = result.ending;
    if (!end) {
      continue;
    }
    ++endings.episodes[static_cast<std::size_t>(end->ending)];
    if (end->ending == Ending::kStuck) {
      ++endings.stuck_pushers[static_cast<std::size_t>(end->pusher)];
      still_steps.push_back(end->still_step);
    }
  }
  if (!still_steps.empty()) {
    const auto middle = still_steps.begin() + static_cast<std::ptrdiff_t>((still_steps.size() - 1) / 2);
    std::nth_element(still_steps.begin(), middle, still_steps.end());
    endings.median_still_step = *middle;
  }
  return endings;
}

EndingsOfPairs endingsOf(const std::vector<EpisodeResult>& episodes) {
  EndingsOfPairs endings;
  endings.reference = endingsOf(episodes, kReferenceClosed);
  endings.engine = endingsOf(episodes, kEngineClosed);
  for (const EpisodeResult& episode : episodes) {
    const RolloutResult& reference = episode.rollouts[kReferenceClosed];
    const RolloutResult& engine = episode.rollouts[kEngineClosed];
    if (reference.success) {
      endings.only_reference_engine_stuck += isStuck(engine) ? 1 : 0;
    } else if (engine.success) {
      endings.only_engine_reference_stuck += isStuck(reference) ? 1 : 0;
    } else {
      endings.neither_reference_stuck += isStuck(reference) ? 1 : 0;
      endings.neither_engine_stuck += isStuck(engine) ? 1 : 0;
    }
  }
  return endings;
}

nlohmann::json toJson(const Endings& endings, bool has_intervals) {
  using nlohmann::json;
  json result = {{"failures", endings.failures()}, {"median_still_step", orNull(endings.median_still_step)}};
  for (const Ending ending : {Ending::kStuck, Ending::kMoving, Ending::kLost}) {
    result[nameOf(ending)] = shareJson(endings.of(ending), endings.failures(), has_intervals);
  }
  for (std::size_t i = 0; i < kPusherEndingNames.size(); ++i) {
    result[std::string("stuck_pusher_") + kPusherEndingNames[i]] =
        shareJson(endings.stuck_pushers[i], endings.failures(), has_intervals);
  }
  if (endings.limitedShare() > kManyLimited) {
    result["commands_at_limit"] = readableJson(endings.limitedShare());
  }
  return result;
}

}  // namespace sim2sim
