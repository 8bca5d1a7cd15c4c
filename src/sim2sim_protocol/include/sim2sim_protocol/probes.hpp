// SPDX-License-Identifier: BSD-3-Clause
/// Probes: further rollouts of a finished episode with one thing changed, most of them in open loop with the
/// reference's exact actions. They are baselines for the divergence of the engine.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "pusht_task/batch_simulator.hpp"
#include "pusht_task/rollout.hpp"
#include "sim2sim_protocol/run_options.hpp"

namespace sim2sim {

/// Simulator in which a probe runs.
enum class ProbedWorld {
  kReference,
  kEngine,
  kVariant,  ///< the reference with other parameters
};

/// Description of a probe. Equal if the names are.
struct Probe {
  std::string name;         ///< name in the column "mode" of episodes.csv: "floor_1e-6"
  ProbedWorld world;        ///< simulator in which it runs
  double tee_offset = 0.0;  ///< [m] offset of the tee's initial position along x, in the table frame
  int reset_every = 0;      ///< [control steps] between resets to the reference's state; 0: none
  std::string variant{};    ///< entry of variantsOf(): "timestep=0.005"; empty: no model variant
  bool closed = false;      ///< whether the policy drives it, not the reference's actions

  /// Whether it depends on the reference alone, so that a cache of the reference's rollouts can have it.
  bool isOfReference() const { return world != ProbedWorld::kEngine; }

  bool operator==(const Probe& other) const { return name == other.name; }
};

/// Floors: the reference replayed from initial states that are moved by 1e-9 m and by 1e-6 m. Their divergence is what
/// tiny changes of the initial state grow to in the reference itself.
const std::vector<Probe>& floorProbes();

/// State-reset (teacher-forced) replay, "engine_reanchored_5": the engine is reset to the reference's full state after
/// steps 5, 10, ...; errors are taken just before. Throws InvalidInput unless `every` [control steps] is from 1 to the
/// task's horizon.
Probe stateResetReplay(int every);

/// Replay in a model variant, "variant_timestep=0.005", or its closed loop, "closed_variant_timestep=0.005". Throws
/// InvalidInput unless `variant` is an entry as in modelVariantsFrom().
Probe modelVariant(const std::string& variant, bool closed);

/// Probes that the options ask for: the floors, and one for each entry of `reanchor`, `model_variants` and
/// `closed_variants`; default variants have none until they are named (nameVariants()). Throws InvalidInput as
/// stateResetReplay() and modelVariant(), and if an entry is there twice.
std::vector<Probe> probesOf(const RunOptions& options);

/// Model variants that the options name, each once: the replayed ones, then those that are only driven.
std::vector<std::string> variantsOf(const RunOptions& options);

/// Reads the option `reanchor` [control steps], such as "1,5,20". Throws InvalidInput unless `text` is a list of
/// integers.
std::vector<int> reanchorFrom(const std::string& text);

/// Word that stands for the default variants of the reference's kind (SimulatorKind::variants).
inline constexpr const char* kDefaultVariants = "default";

/// Reads the options `model_variants` and `closed_variants`: a list such as "timestep=0.005,cone=elliptic:impratio=10".
/// Each variant has parameters of the reference with other values, or is the word kDefaultVariants. Throws InvalidInput
/// for any other text.
std::vector<std::string> modelVariantsFrom(const std::string& text);

/// Finds a probe by its name. Throws InvalidInput if there is none.
Probe probeFrom(const std::string& name);

/// Runs a probe in open loop in a lane of `world`, which is at the probe's start. `reference` is the reference's trace
/// of the episode. `before_step` gets the index of each step before it is taken; it may throw. Throws as
/// BatchSimulator.
pusht::Trace runProbe(const Probe& probe, const pusht::Trace& reference, pusht::BatchSimulator& world, std::size_t lane,
                      const std::function<void(int)>& before_step);

}  // namespace sim2sim
