// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/episode.hpp"

#include <algorithm>
#include <cmath>

namespace sim2sim {
namespace {

RolloutResult resultOf(const Protocol& protocol, std::size_t rollout, const RolloutView& view) {
  RolloutResult result;
  if (!protocol.isFlown(rollout)) {
    return result;
  }
  result.steps = view.rollout.steps();
  result.success = view.rollout.success();
  for (std::size_t i = 0; i < kQuantities.size(); ++i) {
    if (protocol.has(rollout, kQuantities[i].scope)) {
      result.quantities[i] = kQuantities[i].compute(view);
    }
  }
  if (protocol.isClosed(rollout)) {
    result.ending = endingOf(view.rollout);
  }
  if (rollout != kReferenceClosed) {
    result.first_divergence =
        firstDivergenceOf(view.reference, view.rollout.trace(), protocol.bound(), protocol.runTask());
  }
  return result;
}

int limitedCommands(const pusht::Trace& trace, const std::optional<float>& limit) {
  return static_cast<int>(std::count_if(trace.actions.begin(), trace.actions.end(), [&](const pusht::Action& action) {
    return limit && (std::abs(action[0]) >= *limit || std::abs(action[1]) >= *limit);
  }));
}

}  // namespace

Episode::Episode(Protocol protocol, int index, std::array<pusht::Rollout, kModeCount> rollouts,
                 std::vector<std::optional<pusht::Trace>> probes)
    : protocol_(std::move(protocol)), index_(index), rollouts_(std::move(rollouts)), probes_(std::move(probes)) {
  probes_.resize(protocol_.probes().size());
}

int Episode::steps() const {
  return std::max_element(rollouts_.begin(), rollouts_.end(),
                          [](const auto& a, const auto& b) { return a.steps() < b.steps(); })
      ->steps();
}

bool Episode::goesOn(Mode mode) const {
  if (!protocol_.isFlown(mode)) {
    return false;
  }
  return mode == kEngineReplay ? rollouts_[kEngineReplay].steps() < rollouts_[kReferenceClosed].steps()
                               : !rollouts_[mode].finished(protocol_.horizon);
}

bool Episode::finished() const {
  return std::none_of(kModes.begin(), kModes.end(), [this](Mode mode) { return goesOn(mode); });
}

const pusht::Action& Episode::nextReplayed() const {
  return rollouts_[kReferenceClosed].trace().actions.at(rollouts_[kEngineReplay].trace().steps());
}

const pusht::Trace& Episode::trace(std::size_t rollout) const {
  return rollout < kModeCount ? rollouts_[rollout].trace() : probes_.at(rollout - kModeCount).value();
}

EpisodeResult Episode::result() const {
  EpisodeResult result{index_, protocol_.spawnSeed(index_), {}};
  const pusht::Trace& reference = rollouts_[kReferenceClosed].trace();
  for (const Mode mode : kModes) {
    result.rollouts.push_back(
        resultOf(protocol_, mode, {rollouts_[mode], reference, 0, &rollouts_[kEngineReplay].trace()}));
    if (protocol_.isClosed(mode)) {
      result.rollouts.back().limited_commands =
          limitedCommands(rollouts_[mode].trace(), protocol_.runTask().action_limit);
    }
  }
  const std::vector<Probe> probes = protocol_.probes();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const pusht::Rollout rollout(probes_[i].value(), protocol_.runTask());
    const RolloutView view{rollout, reference, probes[i].reset_every};
    result.rollouts.push_back(resultOf(protocol_, rolloutOfProbe(i), view));
  }
  return result;
}

}  // namespace sim2sim
