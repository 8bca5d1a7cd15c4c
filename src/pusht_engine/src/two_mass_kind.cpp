// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_engine/two_mass_kind.hpp"

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_engine/two_mass_lanes.hpp"
#include "pusht_task/simulator_plugin.hpp"

namespace pusht {
namespace {

std::vector<ParameterDescriptor> describeParameters() {
  std::vector<ParameterDescriptor> descriptors;
  descriptors.reserve(two_mass::kParameters.size());
  for (const two_mass::Parameter& parameter : two_mass::kParameters) {
    descriptors.push_back(parameter.descriptor());
  }
  return descriptors;
}

SimulatorModel loadParameters(const ParameterSet& set) {
  TwoMassParameters parameters;
  for (const two_mass::Parameter& parameter : two_mass::kParameters) {
    parameters.*parameter.value = set.get<double>(parameter.name);
  }
  parameters.validate();
  SimulatorModel model;
  model.parameters = set;
  model.make_world = [parameters] { return std::make_unique<TwoMassEngine>(parameters); };
  model.make_lanes = [parameters](int lanes) { return std::make_unique<TwoMassLanes>(lanes, parameters); };
  return model;
}

/// Two discs of point masses, a servo that knows no force, drag on both masses, no frictions, no walls; and a link
/// whose stretch is part of the motion but not of a world's state.
std::vector<std::string> departures() {
  return {"servo_gain",      "servo_limit",
          "pusher_damping",  "pusher_mass",
          "tee_moment",      "tee_damping",
          "tee_yaw_damping", "tee_friction_x",
          "tee_friction_y",  "tee_yaw_friction",
          "friction_shape",  "friction_point",
          "damping_point",   "outline",
          "pusher_radius",   "bar_half_length",
          "bar_half_width",  "stem_end",
          "stem_half_width", "contact_friction",
          "overlap",         "hit",
          "wall_up",         "wall_down",
          "wall_right",      "wall_left",
          "tee_wall_up",     "tee_wall_down",
          "tee_wall_right",  "tee_wall_left"};
}

}  // namespace

const SimulatorKind& twoMassKind() {
  static const SimulatorKind kind = {"two_mass",
                                     "two-mass engine",
                                     PUSHT_ENGINE_VERSION,
                                     describeParameters(),
                                     {},
                                     TwoMassPhysics::kStartTolerance,
                                     loadParameters,
                                     /*variants=*/{},
                                     departures()};
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(two_mass, pusht::twoMassKind);
