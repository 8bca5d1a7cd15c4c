// SPDX-License-Identifier: BSD-3-Clause
/// A run that is read from its bag instead of simulated.
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

/// A world that does what it did when `trace` was recorded. Throws BadDependency if it is given anything else than
/// then: another start, another action, or more actions.
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

/// The rollouts of an episode.
struct RecordedEpisode {
  std::array<pusht::Trace, kModeCount> modes;
  std::vector<std::vector<pusht::WorldState>> probes{};  ///< as those of the protocol
};

/// Runs an episode over recorded worlds. Throws BadDependency if the record does not follow the protocol.
Episode rebuildEpisode(const Protocol& protocol, int index, const RecordedEpisode& record);

/// What the bag of a run holds.
struct RecordedRun {
  RunConfiguration configuration;
  nlohmann::ordered_json provenance;
  DivergenceBands bands;                ///< of these episodes
  std::vector<EpisodeResult> episodes;  ///< the finished ones by index, computed anew from what the worlds did
};

/// Throws InvalidInput if `path` is not the bag of a run or was not closed, BadDependency if what it records does not
/// follow the protocol, RuntimeFault if `stop` holds before the end. `each` gets the finished episodes, in the order in
/// which the bag has them.
RecordedRun readRun(
    const std::filesystem::path& path, const std::function<bool()>& stop = [] { return false; },
    const std::function<void(Episode&&)>& each = [](Episode&&) {});

}  // namespace sim2sim
