// SPDX-License-Identifier: BSD-3-Clause
/// The two-mass engine as a node.
#include <memory>

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/ros/serve.hpp"

namespace {

pusht::Parameters toParameters(const pusht::TwoMassParameters& knobs) {
  pusht::Parameters parameters;
  for (const pusht::two_mass::Knob& knob : pusht::two_mass::kKnobs) {
    parameters.push_back(pusht::parameter(knob.name, pusht::shortestText(knobs.*knob.value)));
  }
  return parameters;
}

pusht::ConfiguredSimulator makeEngine(const pusht::Parameters& parameters) {
  pusht::TwoMassParameters knobs;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    knobs.*pusht::two_mass::kKnobs.at(i).value = pusht::realFromText(parameters[i].name, parameters[i].value);
  }
  return {std::make_unique<pusht::TwoMassEngine>(knobs), toParameters(knobs)};
}

pusht::SimulatorModel load(pusht::ParameterReader& /*parameters*/) {
  pusht::SimulatorModel model;
  model.name = "two_mass";
  model.version = PUSHT_ENGINE_VERSION;
  model.parameters = toParameters({});
  model.make = makeEngine;
  return model;
}

}  // namespace

int main(int argc, char** argv) { return pusht::serveSimulator(argc, argv, "engine", load); }
