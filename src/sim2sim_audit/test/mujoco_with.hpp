// SPDX-License-Identifier: BSD-3-Clause
/// Worlds of MuJoCo with other numbers in the compiled model, or other substeps.
#pragma once

#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <vector>

#include "pusht_mujoco/mujoco_scene.hpp"
#include "pusht_mujoco/mujoco_world.hpp"
#include "pusht_task/constants.hpp"
#include "sim2sim_audit/bench.hpp"

namespace sim2sim::testing {

using pusht::WorldState;

using ChangeMujoco = std::function<void(mjModel&)>;

inline std::shared_ptr<const pusht::MujocoScene> sceneWith(const ChangeMujoco& change) {
  auto scene = std::make_shared<pusht::MujocoScene>();
  auto& model = const_cast<mjModel&>(scene->model());  // NOLINT(cppcoreguidelines-pro-type-const-cast): a planted fault
  change(model);
  mjData* const data = mj_makeData(&model);
  mj_setConst(&model, data);
  mj_deleteData(data);
  return scene;
}

inline WorldFactory mujocoWith(const ChangeMujoco& change) {
  const auto scene = sceneWith(change);
  return [scene] { return std::make_unique<pusht::MujocoWorld>(scene); };
}

inline int geomOf(const mjModel& model, const char* name) { return mj_name2id(&model, mjOBJ_GEOM, name); }
inline int bodyOf(const mjModel& model, const char* name) { return mj_name2id(&model, mjOBJ_BODY, name); }

inline ChangeMujoco scaledGain(double factor) {
  return [factor](mjModel& model) {
    for (int actuator = 0; actuator < model.nu; ++actuator) {
      model.actuator_gainprm[mjNGAIN * actuator] *= factor;
      model.actuator_biasprm[mjNBIAS * actuator + 2] *= factor;
    }
  };
}

inline ChangeMujoco scaledLimit(double factor) {
  return [factor](mjModel& model) {
    for (int i = 0; i < 2 * model.nu; ++i) {
      model.actuator_forcerange[i] *= factor;
    }
  };
}

inline ChangeMujoco scaledDamping(std::initializer_list<int> coordinates, double factor) {
  return [of = std::vector<int>(coordinates), factor](mjModel& model) {
    for (const int coordinate : of) {
      model.dof_damping[coordinate] *= factor;
    }
  };
}

inline ChangeMujoco scaledFriction(std::initializer_list<int> coordinates, double factor) {
  return [of = std::vector<int>(coordinates), factor](mjModel& model) {
    for (const int coordinate : of) {
      model.dof_frictionloss[coordinate] *= factor;
    }
  };
}

inline ChangeMujoco scaledMass(const char* name, double factor, bool with_moment) {
  return [=](mjModel& model) {
    const int body = bodyOf(model, name);
    model.body_mass[body] *= factor;
    for (int i = 0; with_moment && i < 3; ++i) {
      model.body_inertia[3 * body + i] *= factor;
    }
  };
}

inline void shiftCenter(mjModel& model, double along_y) { model.body_ipos[3 * bodyOf(model, "tee") + 1] += along_y; }

inline void scaleMoment(mjModel& model, double factor) {
  for (int i = 0; i < 3; ++i) {
    model.body_inertia[3 * bodyOf(model, "tee") + i] *= factor;
  }
}

inline void moveGeom(mjModel& model, const char* name, int axis, double distance) {
  model.geom_pos[3 * geomOf(model, name) + axis] += distance;
}

/// A world of MuJoCo that counts its own substeps.
class MujocoOfSubsteps : public pusht::Simulator {
 public:
  /// `held`: substeps after which the command becomes 0.
  explicit MujocoOfSubsteps(int substeps, int held = std::numeric_limits<int>::max())
      : Simulator("", pusht::MujocoWorld::kStartTolerance),
        substeps_(substeps),
        held_(held),
        data_(mj_makeData(&scene_.model())) {}

 private:
  struct DeleteData {
    void operator()(mjData* data) const { mj_deleteData(data); }
  };

  void doReset(const WorldState& state) override {
    mj_resetData(&scene_.model(), data_.get());
    const std::array<double, 5> positions = {state.tee_position.x(), state.tee_position.y(), state.tee_yaw,
                                             state.pusher_position.x(), state.pusher_position.y()};
    const std::array<double, 5> velocities = {state.tee_velocity.x(), state.tee_velocity.y(), state.tee_yaw_rate,
                                              state.pusher_velocity.x(), state.pusher_velocity.y()};
    std::copy(positions.begin(), positions.end(), data_->qpos);
    std::copy(velocities.begin(), velocities.end(), data_->qvel);
    mj_forward(&scene_.model(), data_.get());
  }
  void doStep(const pusht::Action& action) override {
    std::copy(action.begin(), action.end(), data_->ctrl);
    for (int i = 0; i < substeps_; ++i) {
      if (i == held_) {
        mju_zero(data_->ctrl, scene_.model().nu);
      }
      mj_step(&scene_.model(), data_.get());
    }
  }
  WorldState doState() const override {
    const mjtNum* const q = data_->qpos;
    const mjtNum* const v = data_->qvel;
    return {{q[3], q[4]}, {v[3], v[4]}, {q[0], q[1]}, {v[0], v[1]}, pusht::wrapAngle(q[2]), v[2]};
  }

  pusht::MujocoScene scene_;
  int substeps_;
  int held_;
  std::unique_ptr<mjData, DeleteData> data_;
};

}  // namespace sim2sim::testing
