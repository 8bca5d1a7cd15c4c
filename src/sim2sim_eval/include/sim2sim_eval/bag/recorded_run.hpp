// SPDX-License-Identifier: BSD-3-Clause
/// Recorded run: its episodes, computed again from a bag instead of simulated.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_task/policy.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/simulator.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/bands.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// World that repeats `trace`, which must outlive it. reset() throws BadDependency for another initial state, step()
/// for another action or for more actions than were recorded.
class RecordedWorld : public pusht::Simulator {
 public:
  explicit RecordedWorld(const pusht::Trace& trace) : trace_(trace) {}

 private:
  void doReset(const pusht::WorldState& state) override;
  void doStep(const pusht::Action& action) override;
  pusht::WorldState doState() const override { return trace_.states.at(step_); }

  const pusht::Trace& trace_;
  std::size_t step_ = 0;
};

/// Recorded rollouts of an episode.
struct RecordedEpisode {
  std::array<pusht::Trace, kModeCount> modes;
  std::vector<std::vector<pusht::WorldState>> probes{};  ///< in the order of Protocol::probes()
};

/// Runs the protocol's episode `index` over recorded worlds. Throws BadDependency if the record does not follow the
/// protocol.
Episode rebuildEpisode(const Protocol& protocol, int index, const RecordedEpisode& record);

/// Content of the bag of a run.
struct RecordedRun {
  RunConfiguration configuration;
  nlohmann::ordered_json provenance;
  DivergenceBands bands;                ///< over the finished episodes
  std::vector<EpisodeResult> episodes;  ///< finished episodes by index, computed from the recorded states
};

/// Reads the bag at `path`. `each` gets every finished episode, in the bag's order. Throws InvalidInput if `path` is
/// not the bag of a run or was not closed, BadDependency if a recorded episode does not follow the protocol,
/// RuntimeFault if `stop` holds before the end.
RecordedRun readRun(
    const std::filesystem::path& path, const std::function<bool()>& stop = [] { return false; },
    const std::function<void(Episode&&)>& each = [](Episode&&) {});

}  // namespace sim2sim
