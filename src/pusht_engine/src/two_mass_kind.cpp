// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/two_mass_kind.hpp"

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_engine/two_mass_lanes.hpp"

namespace pusht {
namespace {

std::vector<ParameterDescriptor> describeKnobs() {
  std::vector<ParameterDescriptor> descriptors;
  descriptors.reserve(two_mass::kKnobs.size());
  for (const two_mass::Knob& knob : two_mass::kKnobs) {
    descriptors.push_back(knob.descriptor());
  }
  return descriptors;
}

SimulatorModel loadKnobs(const ParameterSet& parameters) {
  TwoMassParameters knobs;
  for (const two_mass::Knob& knob : two_mass::kKnobs) {
    knobs.*knob.value = parameters.get<double>(knob.name);
  }
  knobs.validate();
  SimulatorModel model;
  model.parameters = parameters;
  model.make_world = [knobs] { return std::make_unique<TwoMassEngine>(knobs); };
  model.make_lanes = [knobs](int lanes) { return std::make_unique<TwoMassLanes>(lanes, knobs); };
  return model;
}

}  // namespace

const SimulatorKind& twoMassKind() {
  static const SimulatorKind kind = {"two_mass",      "two-mass engine",      PUSHT_ENGINE_VERSION,
                                     describeKnobs(), {"libpusht_engine.so"}, TwoMassPhysics::kStartTolerance,
                                     loadKnobs};
  return kind;
}

}  // namespace pusht
