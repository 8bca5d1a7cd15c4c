// SPDX-License-Identifier: BSD-3-Clause
/// Further rollouts of an episode that has finished: the reference's exact actions once more, with one thing changed.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "pusht_task/batch_simulator.hpp"
#include "pusht_task/rollout.hpp"

namespace sim2sim {

/// Whose physics a probe asks.
enum class ProbedWorld { kReference, kEngine };

/// A rollout in open loop that tells how to read the divergence of the others.
struct Probe {
  std::string name;         ///< its mode in episodes.csv: "floor_1e-6"
  ProbedWorld world;        ///< the reference's physics or the engine's
  double tee_offset = 0.0;  ///< [m] by which the tee's start is moved along x
  int reset_every = 0;      ///< control steps after which the world is put to the reference's state; 0: never

  bool operator==(const Probe& other) const { return name == other.name; }
};

/// The floor: the reference, replayed from a start that is moved by 1e-9 m and by 1e-6 m. How far it then is from
/// itself is what tiny changes of the start grow to.
const std::vector<Probe>& floorProbes();

/// "engine_reanchored_5": the engine is put to the reference's full state after steps 5, 10, ...; errors are taken
/// before. Throws InvalidInput unless `every` is from 1 to the task's horizon.
Probe stateResetReplay(int every);

/// Those that are asked for: the floor, and a re-anchored replay for each of `reanchor`. Throws as stateResetReplay(),
/// and InvalidInput if one is named twice.
std::vector<Probe> probesOf(bool floor, const std::vector<int>& reanchor);

/// "1,5,20": control steps for probesOf(). Throws InvalidInput if `text` is no list of integers.
std::vector<int> reanchorFrom(const std::string& text);

/// The probe of that name. Throws InvalidInput if there is none.
Probe probeFrom(const std::string& name);

/// Runs a probe in a lane of `world`. `start` is that of the episode, `reference` what the reference did in it; before
/// each step, `before_step` is given its index, and may throw. Throws as BatchSimulator does.
pusht::Trace runProbe(const Probe& probe, const pusht::WorldState& start, const pusht::Trace& reference,
                      pusht::BatchSimulator& world, std::size_t lane, const std::function<void(int)>& before_step);

}  // namespace sim2sim
