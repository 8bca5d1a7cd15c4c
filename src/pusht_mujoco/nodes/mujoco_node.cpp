// SPDX-License-Identifier: BSD-3-Clause
/// The reference simulator as a node.
#include <memory>

#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_task/ros/installed_file.hpp"
#include "pusht_task/ros/serve.hpp"

namespace {

pusht::SimulatorModel load(pusht::ParameterReader& parameters) {
  const std::string path = parameters.text("scene", "");
  const auto scene = std::make_shared<const pusht::MujocoScene>(
      path.empty() ? pusht::installedFile("pusht_mujoco", "scenes/pusht.xml") : std::filesystem::path(path));
  pusht::SimulatorModel model;
  model.name = "mujoco";
  model.version = mj_versionString();
  model.provenance = {{"scene", {{"file", scene->path().string()}, {"sha256", scene->sha256()}}}};
  model.make = [scene](const pusht::Parameters& none) {
    return pusht::ConfiguredSimulator{std::make_unique<pusht::MujocoWorld>(scene), none};
  };
  return model;
}

}  // namespace

int main(int argc, char** argv) { return pusht::serveSimulator(argc, argv, "mujoco", load); }
