// SPDX-License-Identifier: BSD-3-Clause
/// Kind whose worlds are scenes of an engine by others (scene_world.hpp): its parameters follow from two lists.
#pragma once

#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "pusht_task/error.hpp"
#include "pusht_task/parameters.hpp"
#include "pusht_task/physics_numbers.hpp"
#include "pusht_task/scene_world.hpp"
#include "pusht_task/simulator_kind.hpp"
#include "pusht_task/substeps.hpp"
#include "pusht_task/switches.hpp"

namespace pusht {

/// Description of a number of the engine's solver: a member of the struct `Parameters`.
template <class Parameters>
struct SolverNumber {
  const char* name;
  const char* unit;     ///< empty: none
  const char* meaning;  ///< a phrase for people
  std::variant<std::int64_t Parameters::*, double Parameters::*> value;
  double least;
  double greatest;
  const char* reason;  ///< why the range ends where it does
};

/// Order of a kind's parameters, in which results and hashes have them.
enum class ParameterOrder { kSwitchesFirst, kNumbersFirst };

/// Parameters of a kind of scenes: `preset`, which is `mapped` (all switches on) or `idiomatic` (all off), and the
/// scene's `kSwitches`; its `kNumbers` and `substep`; the numbers of the task's physics.
template <class SceneOfKind>
std::vector<ParameterDescriptor> sceneDescriptors(ParameterOrder order) {
  const auto& switches = SceneOfKind::kSwitches;
  std::vector<ParameterDescriptor> front =
      switchDescriptors(switches, {presetOf("mapped", switches, true), presetOf("idiomatic", switches, false)});
  std::vector<ParameterDescriptor> back;
  const typename SceneOfKind::Parameters defaults;
  for (const auto& number : SceneOfKind::kNumbers) {
    const ParameterValue value =
        std::visit([&](auto member) { return ParameterValue(defaults.*member); }, number.value);
    back.push_back({number.name, number.unit, number.meaning, value, number.least, number.greatest, number.reason});
  }
  back.push_back(substepDescriptor("substep"));
  if (order == ParameterOrder::kNumbersFirst) {
    std::swap(front, back);
  }
  front.insert(front.end(), back.begin(), back.end());
  const std::vector<ParameterDescriptor> of_task = physicsDescriptors();
  front.insert(front.end(), of_task.begin(), of_task.end());
  return front;
}

/// Model of worlds with these values of sceneDescriptors().
template <class SceneOfKind>
SimulatorModel modelOfScenes(const ParameterSet& set, const Task& task) {
  typename SceneOfKind::Parameters parameters;
  readSwitches(set, SceneOfKind::kSwitches, parameters);
  for (const auto& number : SceneOfKind::kNumbers) {
    std::visit(
        [&](auto member) { parameters.*member = set.get<std::decay_t<decltype(parameters.*member)>>(number.name); },
        number.value);
  }
  parameters.substep = set.get<double>("substep");
  if (task.physics.drive == Drive::kPosition && !parameters.servo) {
    throw InvalidInput("servo false: must be true in the task " + task.name + ": the engine's motor holds velocities");
  }
  const Physics physics = physicsWith(set, task.physics);
  return modelOfWorlds(set, [parameters, physics, &task] { return worldOf<SceneOfKind>(parameters, physics, task); });
}

/// Kind of scenes. `prepare` is called whenever a model is loaded: it makes the library ready, and may throw
/// BadDependency. Contacts are the engine's own, so worlds depart from the task in their overlap.
template <class SceneOfKind>
SimulatorKind kindOfScenes(const std::string& name, const std::string& version,
                           const std::vector<std::string>& libraries, void (*prepare)(),
                           ParameterOrder order = ParameterOrder::kSwitchesFirst) {
  const auto load = [prepare](const ParameterSet& set, const Task& task) {
    prepare();
    return modelOfScenes<SceneOfKind>(set, task);
  };
  return {name,        SceneOfKind::kTitle,
          version,     sceneDescriptors<SceneOfKind>(order),
          libraries,   SceneOfKind::kStartTolerance,
          load,        {"substep=0.005"},
          {"overlap"}, {}};
}

}  // namespace pusht
