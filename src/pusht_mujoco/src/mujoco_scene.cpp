// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_mujoco/mujoco_scene.hpp"

#include <algorithm>
#include <array>
#include <new>

#include "mujoco_guard.hpp"
#include "mujoco_modeling.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "pusht_task/substeps.hpp"
#include "scene_check.hpp"
#include "scene_of_task.hpp"
#include "shipped_scene.hpp"

namespace pusht {
namespace {

/// Loads and compiles the scene; null if that fails. `complaint` gets MuJoCo's message, on one line.
mjModel* loadModel(const std::string& path, std::string& complaint) {
  std::array<char, 1000> message{};
  mjModel* model = nullptr;
  MujocoGuard::takeWarning();
  MujocoGuard::run([&] { model = mj_loadXML(path.c_str(), nullptr, message.data(), message.size()); });
  std::replace(message.begin(), message.end(), '\n', ' ');
  complaint = message.data();
  if (complaint.empty()) {
    complaint = MujocoGuard::takeWarning();
  }
  return model;
}

/// MJCF of a task's scene.
std::string mjcfOf(const Task& task) { return &task == &fullCircle() ? kShippedScene : sceneOf(task); }

MujocoModel copyOf(const mjModel& model) {
  mjModel* copy = nullptr;
  MujocoGuard::run([&] { copy = mj_copyModel(nullptr, &model); });
  if (copy == nullptr) {
    throw std::bad_alloc();
  }
  return MujocoModel(copy);
}

}  // namespace

MujocoScene::MujocoScene() : MujocoScene(fullCircle()) {}

MujocoScene::MujocoScene(const Task& task) {
  const std::string xml = mjcfOf(task);
  sha256_ = pusht::sha256(xml);
  model_ = compiledScene(xml);
}

MujocoScene::MujocoScene(const std::filesystem::path& path, const Task& task) {
  const std::string xml = readFile(path, "scene", kLargestSmallFile);
  if (xml.find("<include") != std::string::npos) {
    throw InvalidInput("scene " + path.string() + ": must not include other files, which its checksum would not cover");
  }
  sha256_ = pusht::sha256(xml);
  std::string complaint;
  model_.reset(loadModel(path.string(), complaint));
  try {
    if (model_ != nullptr) {
      checkScene(*model_,
                 *compiledScene(mjcfOf(task)));  // first: a wrong field says more than what MuJoCo found it to lead to
    }
    if (!complaint.empty()) {
      throw InvalidInput(complaint);
    }
  } catch (const InvalidInput& error) {
    throw InvalidInput("scene " + path.string() + ": " + error.what());
  }
}

MujocoScene::MujocoScene(const MujocoScene& scene, const ParameterSet& parameters)
    : sha256_(scene.sha256_), model_(copyOf(scene.model())) {
  applyModeling(parameters, *model_);
}

int MujocoScene::substepsPerControlStep() const { return pusht::substepsPerControlStep(model_->opt.timestep); }

}  // namespace pusht
