// SPDX-License-Identifier: BSD-3-Clause
/// The reference simulator.
#pragma once

#include <memory>
#include <optional>

#include "pusht_mujoco/mujoco_scene.hpp"
#include "pusht_task/simulator.hpp"

namespace pusht {

/// One PushT world in MuJoCo. Worlds of one scene may step in different threads.
class MujocoWorld : public Simulator {
 public:
  static constexpr double kStartTolerance = 1e-12;  ///< [m, rad, m/s, rad/s]

  explicit MujocoWorld(std::shared_ptr<const MujocoScene> scene, const Task& task = fullCircle());

 private:
  struct DeleteData {
    void operator()(mjData* data) const { mj_deleteData(data); }
  };

  void doReset(const WorldState& state) override;
  /// Throws SimulationFault on any warning of MuJoCo (it may have reset the state on its own), InternalError
  /// on an error of MuJoCo.
  void doStep(const Action& action) override;
  /// Until the first step it is the start's, so that a reset to it changes no bit.
  WorldState doState() const override { return start_ ? *start_ : stateOfBodies(); }
  WorldState stateOfBodies() const;

  void refuseWarnings() const;

  std::shared_ptr<const MujocoScene> scene_;
  std::unique_ptr<mjData, DeleteData> data_;
  std::optional<WorldState> start_;  ///< if the body's origin is not the tee's
};

}  // namespace pusht
