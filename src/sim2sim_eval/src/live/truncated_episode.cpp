// SPDX-License-Identifier: BSD-3-Clause
#include "live/truncated_episode.hpp"

#include <algorithm>
#include <cstddef>

namespace sim2sim {

Episode truncatedEpisode(const Protocol& protocol, const Episode& whole, int steps) {
  const auto begin = [&](Mode mode) {
    return pusht::Rollout(whole.rollout(mode).trace().states.front(), nullptr, protocol.runTask());
  };
  Episode episode(protocol, whole.index(), {begin(kReferenceClosed), begin(kEngineClosed), begin(kEngineReplay)});
  for (const Mode mode : kModes) {
    const pusht::Trace& trace = whole.rollout(mode).trace();
    const std::size_t common = std::min(trace.steps(), static_cast<std::size_t>(steps));
    for (std::size_t k = 0; k < common; ++k) {
      episode.record(mode, trace.actions[k], trace.states[k + 1]);
    }
  }
  return episode;
}

}  // namespace sim2sim
