// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/rigid_body_kind.hpp"

#include <functional>

#include "pusht_engine/rigid_body_engine.hpp"
#include "pusht_task/simulator_plugin.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {
namespace {

using rigid_body::kSwitches;
using rigid_body::Switch;

constexpr const char* kSubstepLength = "substep";

Preset preset(const std::string& word, const std::function<bool(const Switch&)>& is_on) {
  Preset result = {word, {}};
  for (const Switch& each : kSwitches) {
    result.settings.emplace_back(each.name, textOf(is_on(each)));
  }
  return result;
}

std::vector<ParameterDescriptor> describeRigidBody() {
  ParameterDescriptor presets = {"preset", "", "sets the switches that are not set by name", std::string("faithful")};
  presets.words = {"faithful", "shaped", "simple"};
  presets.presets = {preset("faithful", [](const Switch&) { return true; }),
                     preset("shaped",
                            [](const Switch& each) {
                              return each.value == &RigidBodyParameters::shape ||
                                     each.value == &RigidBodyParameters::tee_inertia;
                            }),
                     preset("simple", [](const Switch&) { return false; })};
  std::vector<ParameterDescriptor> descriptors = {presets};
  for (const Switch& each : kSwitches) {
    descriptors.push_back({each.name, "", each.meaning, RigidBodyParameters().*each.value});
  }
  descriptors.push_back(substepDescriptor(kSubstepLength));
  return descriptors;
}

SimulatorModel load(const ParameterSet& parameters) {
  RigidBodyParameters values;
  for (const Switch& each : kSwitches) {
    values.*each.value = parameters.get<bool>(each.name);
  }
  values.substep = parameters.get<double>(kSubstepLength);
  return modelOfWorlds(parameters, [values] { return std::make_unique<RigidBodyEngine>(values); });
}

}  // namespace

const SimulatorKind& rigidBodyKind() {
  static const SimulatorKind kind = {"rigid_body",
                                     "rigid-body engine",
                                     PUSHT_ENGINE_VERSION,
                                     describeRigidBody(),
                                     {"libccd.so"},
                                     RigidBodyPhysics::kStartTolerance,
                                     load,
                                     {"substep=0.005"}};
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(rigid_body, pusht::rigidBodyKind);
