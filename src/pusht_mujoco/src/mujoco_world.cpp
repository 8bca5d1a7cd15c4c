// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_mujoco/mujoco_world.hpp"

#include <new>
#include <string>
#include <utility>

#include "coordinates.hpp"
#include "mujoco_guard.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/mapping.hpp"

namespace pusht {
namespace {

mjData* makeData(const mjModel& model) {
  mjData* data = nullptr;
  MujocoGuard::run([&] { data = mj_makeData(&model); });
  if (data == nullptr) {
    throw std::bad_alloc();
  }
  return data;
}

}  // namespace

MujocoWorld::MujocoWorld(std::shared_ptr<const MujocoScene> scene, const Task& task)
    : Simulator("", kStartTolerance, task), scene_(std::move(scene)), data_(makeData(scene_->model())) {}

void MujocoWorld::doReset(const WorldState& start) {
  const double body_origin = task().physics.table_point;
  const WorldState state = atPointOfTee(start, body_origin);
  const mjModel* model = &scene_->model();
  mjData* data = data_.get();
  MujocoGuard::run([&] {
    mj_resetData(model, data);  // clears the warm start, which is hidden state
    data->qpos[kTeeX] = state.tee_position.x();
    data->qpos[kTeeY] = state.tee_position.y();
    data->qpos[kTeeYaw] = state.tee_yaw;
    data->qpos[kPusherX] = state.pusher_position.x();
    data->qpos[kPusherY] = state.pusher_position.y();
    data->qvel[kTeeX] = state.tee_velocity.x();
    data->qvel[kTeeY] = state.tee_velocity.y();
    data->qvel[kTeeYaw] = state.tee_yaw_rate;
    data->qvel[kPusherX] = state.pusher_velocity.x();
    data->qvel[kPusherY] = state.pusher_velocity.y();
    mj_forward(model, data);
  });
  refuseWarnings();
  start_.reset();
  if (body_origin != 0.0) {
    requireStart(start, stateOfBodies(), startTolerance());
    start_ = start;
  }
}

void MujocoWorld::doStep(const Action& action) {
  const mjModel* model = &scene_->model();
  mjData* data = data_.get();
  const double start = data->time;
  const int substeps = scene_->substepsPerControlStep();
  const Eigen::Vector2d command = commandOf(action, task());
  start_.reset();
  MujocoGuard::run([&] {
    data->ctrl[0] = command.x();
    data->ctrl[1] = command.y();
    for (int i = 0; i < substeps; ++i) {
      mj_step(model, data);
    }
  });
  refuseWarnings();
  if (!(data->time > start)) {
    throw SimulationFault("MuJoCo: time went from " + std::to_string(start) + " to " + std::to_string(data->time) +
                          " s: must grow in a step");
  }
}

WorldState MujocoWorld::stateOfBodies() const {
  WorldState state;
  state.pusher_position = {data_->qpos[kPusherX], data_->qpos[kPusherY]};
  state.pusher_velocity = {data_->qvel[kPusherX], data_->qvel[kPusherY]};
  state.tee_position = {data_->qpos[kTeeX], data_->qpos[kTeeY]};
  state.tee_velocity = {data_->qvel[kTeeX], data_->qvel[kTeeY]};
  state.tee_yaw = wrapAngle(data_->qpos[kTeeYaw]);
  state.tee_yaw_rate = data_->qvel[kTeeYaw];
  return atPointOfTee(state, -task().physics.table_point);
}

void MujocoWorld::refuseWarnings() const {
  for (int i = 0; i < mjNWARNING; ++i) {
    if (data_->warning[i].number > 0) {
      throw SimulationFault(std::string("MuJoCo: ") + mju_warningText(i, data_->warning[i].lastinfo));
    }
  }
}

}  // namespace pusht
