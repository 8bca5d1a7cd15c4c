// SPDX-License-Identifier: BSD-3-Clause
/// Agreement of simulators: how far each two of them part when both replay the same actions from the same states, and
/// which of them is nearest to all others.
#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_statistics/centrality.hpp"

namespace sim2sim {

/// Divergence of two replays, and that of its null model, by episode.
struct DistanceSamples {
  std::vector<double> divergence;
  std::vector<double> null_model;
};

/// Distances of all pairs, of one divergence over one kind of replay.
struct AgreementSamples {
  /// By two simulators: (i, j) is the distance of j from i. Of one way (i, j) is (j, i); of both ways it is along the
  /// episodes of i. Empty on the diagonal.
  std::vector<std::vector<DistanceSamples>> pairs;
  std::vector<std::vector<DistanceSamples>> variants;  ///< distance of a simulator from its variants: by both
};

/// Figures of all pairs, in the unit of the divergence. Intervals are those that a run has of its divergences.
struct AgreementFigures {
  std::vector<std::vector<Estimate>> distances;  ///< 0 on the diagonal
  std::vector<std::vector<Estimate>> variants;
  std::vector<Estimate> others;  ///< by simulator: mean distance to all others, both ways
  std::optional<std::vector<Centrality>> centrality;
};

/// Figures of at least two simulators over the same episodes. `quantity` is the divergence.
AgreementFigures figuresOf(const AgreementSamples& samples, const Quantity& quantity);

/// Divergences of an agreement: position and angle, over whole episodes.
inline constexpr std::size_t kAgreementDivergences = kWholeEpisodePairs;

/// Figures of one kind of replay.
struct AgreementReplay {
  int reset_every;  ///< [control steps] between resets to the reference's state; 0: open loop
  std::array<AgreementFigures, kAgreementDivergences> figures;
};

/// A simulator of the list.
struct AgreementSimulator {
  std::string name;  ///< text that asks for it: "mujoco:timestep=0.005"
  SimulatorRecord record;
  std::vector<std::string> variants;  ///< texts that ask for its model variants
};

/// Agreement of all pairs of a list of simulators.
struct Agreement {
  nlohmann::json run;                        ///< policy, starts and options, as describe() has them
  std::optional<SimulatorRecord> reference;  ///< whose episodes all replay; none: each simulator its own, both ways
  std::vector<AgreementSimulator> simulators;
  std::vector<AgreementReplay> replays;
};

}  // namespace sim2sim
