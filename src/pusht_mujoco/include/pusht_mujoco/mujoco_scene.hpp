// SPDX-License-Identifier: BSD-3-Clause
/// The PushT scene, loaded once and shared by any number of worlds.
#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <memory>
#include <string>

#include "pusht_task/parameters.hpp"
#include "pusht_task/task.hpp"

namespace pusht {

/// Deleter for a model of MuJoCo.
struct DeleteMujocoModel {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
using MujocoModel = std::unique_ptr<mjModel, DeleteMujocoModel>;

/// Compiled MuJoCo model that is known to be PushT. Immutable; shared between threads freely.
class MujocoScene {
 public:
  /// The one that comes with the suite; needs no file.
  MujocoScene();

  /// That of a task: the one that comes with the suite, or for another task than full_circle sceneOf() it.
  explicit MujocoScene(const Task& task);

  /// Loads and checks `path`. Throws InvalidInput with the path and MuJoCo's message if it does not load,
  /// or with the field, its value and the expected one if it is not this task.
  explicit MujocoScene(const std::filesystem::path& path, const Task& task = fullCircle());

  /// `scene` with another modeling; `parameters` are those of the kind `mujoco`.
  MujocoScene(const MujocoScene& scene, const ParameterSet& parameters);

  const mjModel& model() const { return *model_; }
  int substepsPerControlStep() const;
  const std::string& sha256() const { return sha256_; }

 private:
  std::string sha256_;
  MujocoModel model_;
};

}  // namespace pusht
