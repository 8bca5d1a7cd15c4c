// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_mujoco/mujoco_kind.hpp"

#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_task/simulator_plugin.hpp"

namespace pusht {
namespace {

constexpr const char* kScene = "scene";
constexpr const char* kShipped = "shipped";

SimulatorModel load(const ParameterSet& parameters) {
  const auto& file = parameters.get<std::string>(kScene);
  const bool shipped = file == kShipped;
  const auto scene = shipped ? std::make_shared<const MujocoScene>() : std::make_shared<const MujocoScene>(file);
  SimulatorModel model;
  model.parameters = parameters;
  model.provenance[kScene]["sha256"] = scene->sha256();
  if (!shipped) {
    model.provenance[kScene]["file"] = file;
  }
  model.make_world = [scene] { return std::make_unique<MujocoWorld>(scene); };
  model.make_lanes = lanesOf(model.make_world);
  return model;
}

}  // namespace

const SimulatorKind& mujocoKind() {
  static const SimulatorKind kind = {
      "mujoco",
      "MuJoCo",
      mj_versionString(),
      {{kScene, "", "MJCF file, or 'shipped' for the one that comes with the suite; must be this task",
        std::string(kShipped)}},
      {"libmujoco.so", "libccd.so"},  // libccd finds its contacts
      MujocoWorld::kStartTolerance,
      load};
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(mujoco, pusht::mujocoKind);
