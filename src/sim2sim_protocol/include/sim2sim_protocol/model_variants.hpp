// SPDX-License-Identifier: BSD-3-Clause
/// Model variants of a reference: the same physics by other numerics, such as another time step. Their divergence from
/// the reference is a baseline beside null model and floor: how far a simulator is from itself.
#pragma once

#include <string>
#include <vector>

#include "pusht_task/simulator_kind.hpp"
#include "sim2sim_protocol/flight.hpp"
#include "sim2sim_protocol/run_options.hpp"

namespace sim2sim {

/// Names default variants in the options `model_variants` and `closed_variants` by their parameters, and writes all
/// values as the kind reads them ("timestep=5e-3" becomes "timestep=0.005"). A default variant that is the reference
/// itself is left out. `parameters` are the reference's. Throws InvalidInput with variant and rule if the kind has no
/// such parameter or value, if a variant sets a parameter twice, if it is the reference itself or the same model as
/// another of its list, or if no default one is left.
void nameVariants(const pusht::SimulatorKind& kind, const pusht::ParameterSet& parameters, RunOptions& options);

/// Loads the variants that `options` names. Throws InvalidInput as nameVariants(), and what SimulatorKind::load throws.
std::vector<pusht::SimulatorModel> loadVariants(const pusht::SimulatorKind& kind, const pusht::ParameterSet& parameters,
                                                const RunOptions& options);

/// Model variant that was loaded.
struct LoadedVariant {
  std::string name;  ///< "timestep=0.005"
  pusht::SimulatorModel model;
};

/// Default variants of a kind, loaded, but for the reference itself; there may be none. Throws what SimulatorKind::load
/// throws.
std::vector<LoadedVariant> loadDefaultVariants(const pusht::SimulatorKind& kind, const pusht::ParameterSet& parameters,
                                               const pusht::Task& task = pusht::fullCircle());

/// A world of each variant.
VariantWorlds worldsOf(const std::vector<pusht::SimulatorModel>& variants);

}  // namespace sim2sim
