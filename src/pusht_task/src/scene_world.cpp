// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/scene_world.hpp"

#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {

void Scene::substep(const Eigen::Vector2d& command) {
  applyServo(command);
  applyDrag();
  advance();
}

void Scene::addWalls() {
  for (const PlacedBox& wall : wallBoxes(physics_)) {
    addWall(wall);
  }
}

void Scene::addTableFriction() {
  if (mapping_.table_friction) {
    addFrictionPerAxis(tablePoint());
  } else {
    addIdiomaticFriction();
  }
}

Eigen::Vector2d Scene::tablePoint() const { return {0.0, 0.0 - physics_.table_point}; }  // which is never -0

void Scene::applyDrag() {
  if (mapping_.drag) {
    applyDragAt(tablePoint());
  }
}

double Scene::pusherMass() const { return pusht::pusherMass(physics_, mapping_.servo ? mapping_.substep : 0.0); }

TeeInertia Scene::teeInertia() const { return pusht::teeInertia(physics_, mapping_.drag ? mapping_.substep : 0.0); }

SceneWorld::SceneWorld(const std::string& name, double start_tolerance, double substep, MakeScene make_scene,
                       const Task& task)
    : Simulator(name, start_tolerance, task),
      name_(name),
      substeps_(substepsPerControlStep(substep)),
      make_scene_(std::move(make_scene)) {
  SceneWorld::doReset({});
}

void SceneWorld::requireNone(const std::string& fault, const char* when) const {
  if (!fault.empty()) {
    throw SimulationFault(name_ + ": " + when + ": " + fault);
  }
}

void SceneWorld::doReset(const WorldState& state) {
  std::unique_ptr<Scene> scene = make_scene_();
  requireNone(scene->faultOfPositions(state), "reset");
  const WorldState start = scene->start(state);
  requireNone(scene->faultOfSpeeds(), "reset");
  requireNone(faultOfStart(state, scene->state(), startTolerance()), "reset");
  scene_ = std::move(scene);
  start_ = start;
}

void SceneWorld::doStep(const Action& action) {
  start_.reset();
  const Eigen::Vector2d command = commandOf(action, task());
  for (int i = 0; i < substeps_; ++i) {
    scene_->substep(command);
    requireNone(scene_->faultOfSpeeds(), "step");
  }
  requireNone(scene_->faultOfPositions(scene_->state()), "step");
}

}  // namespace pusht
