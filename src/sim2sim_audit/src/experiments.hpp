// SPDX-License-Identifier: BSD-3-Clause
/// Experiments of an audit: scripted resets and steps in one world, each with the properties that it estimates by a
/// closed form or a fit.
#pragma once

#include <vector>

#include "sim2sim_audit/bench.hpp"
#include "sim2sim_audit/measurements.hpp"

namespace sim2sim {

/// Experiment: what it does, and what it estimates.
struct Experiment {
  const char* name;
  std::vector<Property> estimates;
  /// Fills `measurements`; may read what earlier experiments found. Throws what the world throws, and
  /// std::runtime_error with the reason where it cannot measure.
  void (*carry_out)(Bench& bench, Measurements& measurements);
  bool needs_velocities = false;  ///< whether actions must be velocities, so that pushes are steady
};

/// All experiments, in the order in which they are carried out.
const std::vector<Experiment>& allExperiments();

/// Estimates of all properties of a world. An experiment that fails says so in its properties, and the others go on,
/// unless it throws WorldLost: then all properties without a value say so.
Measurements measure(Bench& bench);

/// Experiments on starts, repetition, hidden and stale state.
std::vector<Experiment> bookkeepingExperiments();
/// Experiments on the yaw, and on axes, point and unit of velocities.
std::vector<Experiment> frameExperiments();
/// Experiments on what a command does, when, and how far.
std::vector<Experiment> actionExperiments();
/// Experiments on the pusher's servo.
std::vector<Experiment> servoExperiments();
/// Experiments on sizes and places of the bodies, by touch.
std::vector<Experiment> shapeExperiments();
/// Experiments on the tee alone on its table, and on its mass and moment.
std::vector<Experiment> teeExperiments();
/// Experiments on contacts of pusher and tee.
std::vector<Experiment> contactExperiments();
/// Experiments on the places of the walls.
std::vector<Experiment> wallExperiments();

}  // namespace sim2sim
