// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_mujoco/mujoco_kind.hpp"

#include "mujoco_modeling.hpp"
#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_task/simulator_plugin.hpp"

namespace pusht {
namespace {

constexpr const char* kScene = "scene";
constexpr const char* kShipped = "shipped";

std::vector<ParameterDescriptor> describeParameters() {
  std::vector<ParameterDescriptor> all = {
      {kScene, "", "MJCF file, or 'shipped' for the one that comes with the suite; must be this task",
       std::string(kShipped)}};
  all.insert(all.end(), modelingParameters().begin(), modelingParameters().end());
  return all;
}

SimulatorModel load(const ParameterSet& parameters, const Task& task) {
  const auto& file = parameters.get<std::string>(kScene);
  const bool shipped = file == kShipped;
  auto scene = shipped ? std::make_shared<const MujocoScene>(task) : std::make_shared<const MujocoScene>(file, task);
  if (changesModel(parameters)) {
    scene = std::make_shared<const MujocoScene>(*scene, parameters);
  }
  SimulatorModel model =
      modelOfWorlds(parameters, [scene, &task] { return std::make_unique<MujocoWorld>(scene, task); });
  model.provenance[kScene]["sha256"] = scene->sha256();
  if (!shipped) {
    model.provenance[kScene]["file"] = file;
  }
  return model;
}

}  // namespace

const SimulatorKind& mujocoKind() {
  static const SimulatorKind kind = {"mujoco",
                                     "MuJoCo",
                                     mj_versionString(),
                                     describeParameters(),
                                     {"libmujoco.so", "libccd.so"},  // libccd finds its contacts
                                     MujocoWorld::kStartTolerance,
                                     load,
                                     {"timestep=0.005", "integrator=Euler", "cone=elliptic"},
                                     {},
                                     {}};
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(mujoco, pusht::mujocoKind);
