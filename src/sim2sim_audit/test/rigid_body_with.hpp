// SPDX-License-Identifier: BSD-3-Clause
/// The rigid-body engine with other constants, or other substeps.
#pragma once

#include <functional>
#include <memory>

#include "pusht_engine/rigid_body_engine.hpp"
#include "pusht_task/constants.hpp"
#include "sim2sim_audit/bench.hpp"

namespace sim2sim::testing {

using RigidModel = pusht::rigid_body::Model;

using ChangeRigid = std::function<void(RigidModel&)>;

/// The engine with other constants, and another number of substeps.
struct PlantedPhysics : pusht::RigidBodyPhysics {
  struct Parameters {
    ChangeRigid change = [](RigidModel&) {};
    int substeps = pusht::kSubstepsPerControlStep;
  };
  struct Model : RigidModel {
    int substeps;
  };

  static Model modelOf(const Parameters& parameters) {
    Model model = {pusht::rigid_body::modelOf({}), parameters.substeps};
    parameters.change(model);
    return model;
  }
  static int substepsOf(const Model& model) { return model.substeps; }
  static void substep(const Model& model, const Eigen::Vector2d& command, Bodies& bodies) {
    pusht::rigid_body::substep(model, command, bodies);
  }
};
using PlantedEngine = pusht::PlanarSimulator<PlantedPhysics>;

inline WorldFactory rigidWith(const ChangeRigid& change, int substeps = pusht::kSubstepsPerControlStep) {
  return [=] { return std::make_unique<PlantedEngine>(PlantedPhysics::Parameters{change, substeps}); };
}

inline ChangeRigid scaled(double RigidModel::*number, double factor) {
  return [=](RigidModel& model) { model.*number *= factor; };
}

inline ChangeRigid rigidServo(double gain_factor, double damping_factor) {
  return [=](RigidModel& model) {
    model.servo_gain *= gain_factor;
    model.pusher_damping *= damping_factor;
    model.servo_derivative = model.servo_gain + model.pusher_damping;
  };
}

/// The tee's moment about its origin, of a moment about the center of mass that is so many times the task's.
inline void scaleRigidMoment(RigidModel& model, double factor) {
  const double of_offset = model.tee_mass * pusht::kCenterOfMassOffset * pusht::kCenterOfMassOffset;
  model.tee_moment = of_offset + factor * (model.tee_moment - of_offset);
}

}  // namespace sim2sim::testing
