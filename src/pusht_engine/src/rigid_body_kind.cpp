// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/rigid_body_kind.hpp"

#include "pusht_engine/rigid_body_engine.hpp"
#include "pusht_task/physics_numbers.hpp"
#include "pusht_task/simulator_plugin.hpp"
#include "pusht_task/substeps.hpp"
#include "pusht_task/switches.hpp"

namespace pusht {
namespace {

using rigid_body::kSwitches;

constexpr const char* kContinuous = "continuous";
constexpr const char* kSubstepLength = "substep";

std::vector<ParameterDescriptor> describeRigidBody() {
  const auto is_of_the_body = [](const rigid_body::Switch& each) {
    return each.value == &RigidBodyParameters::shape || each.value == &RigidBodyParameters::tee_inertia;
  };
  std::vector<ParameterDescriptor> descriptors = switchDescriptors(
      kSwitches, {presetOf("faithful", kSwitches, true), presetOf("shaped", kSwitches, is_of_the_body),
                  presetOf("simple", kSwitches, false)});
  descriptors.push_back({kContinuous, "",
                         "bodies that would meet within a substep stop where they meet; off: they overlap or pass "
                         "through each other first, as in MuJoCo",
                         false});
  descriptors.push_back(substepDescriptor(kSubstepLength));
  const std::vector<ParameterDescriptor> of_task = physicsDescriptors();
  descriptors.insert(descriptors.end(), of_task.begin(), of_task.end());
  return descriptors;
}

SimulatorModel load(const ParameterSet& parameters, const Task& task) {
  RigidBodyParameters values;
  readSwitches(parameters, kSwitches, values);
  values.continuous = parameters.get<bool>(kContinuous);
  values.substep = parameters.get<double>(kSubstepLength);
  const rigid_body::Model model = rigid_body::modelOf(values, physicsWith(parameters, task.physics));
  return modelOfWorlds(parameters, [model, &task] { return std::make_unique<RigidBodyEngine>(model, task); });
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
                                     {"substep=0.005"},
                                     {},
                                     {}};
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(rigid_body, pusht::rigidBodyKind);
