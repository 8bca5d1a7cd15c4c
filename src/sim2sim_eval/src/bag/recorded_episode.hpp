// SPDX-License-Identifier: BSD-3-Clause
/// Recorded episode: the protocol run over recorded worlds, which checks that the record follows the protocol.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "pusht_task/rollout.hpp"
#include "pusht_task/simulator.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// World that repeats `trace`, which must outlive it. reset() throws BadDependency for another initial state, step()
/// for another action or for more actions than were recorded.
class RecordedWorld : public pusht::Simulator {
 public:
  RecordedWorld(const pusht::Trace& trace, const pusht::Task& task)
      : Simulator("", pusht::kStartTolerance, task), trace_(trace) {}

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

}  // namespace sim2sim
