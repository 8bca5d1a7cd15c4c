// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/two_mass_kind.hpp"

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_engine/two_mass_lanes.hpp"
#include "pusht_task/simulator_plugin.hpp"

namespace pusht {
namespace {

std::vector<ParameterDescriptor> describeParameters() {
  std::vector<ParameterDescriptor> descriptors;
  descriptors.reserve(two_mass::kParameters.size());
  for (const two_mass::Parameter& parameter : two_mass::kParameters) {
    descriptors.push_back(parameter.descriptor());
  }
  return descriptors;
}

SimulatorModel loadParameters(const ParameterSet& set) {
  TwoMassParameters parameters;
  for (const two_mass::Parameter& parameter : two_mass::kParameters) {
    parameters.*parameter.value = set.get<double>(parameter.name);
  }
  parameters.validate();
  SimulatorModel model;
  model.parameters = set;
  model.make_world = [parameters] { return std::make_unique<TwoMassEngine>(parameters); };
  model.make_lanes = [parameters](int lanes) { return std::make_unique<TwoMassLanes>(lanes, parameters); };
  return model;
}

}  // namespace

const SimulatorKind& twoMassKind() {
  static const SimulatorKind kind = {"two_mass",           "two-mass engine",      PUSHT_ENGINE_VERSION,
                                     describeParameters(), {}, TwoMassPhysics::kStartTolerance,
                                     loadParameters};
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(two_mass, pusht::twoMassKind);
