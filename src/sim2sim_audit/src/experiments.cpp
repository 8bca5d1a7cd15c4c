// SPDX-License-Identifier: BSD-3-Clause
#include "experiments.hpp"

#include <exception>
#include <utility>

namespace sim2sim {
namespace {

/// Carries `experiment` out; if it fails, its properties say so. Throws WorldLost.
void carryOut(const Experiment& experiment, Bench& bench, Measurements& measurements) {
  if (experiment.needs_velocities && !bench.commandsVelocities()) {
    for (const Property property : experiment.estimates) {
      measurements.fail(property, "actions of the task are positions");
    }
    return;
  }
  try {
    experiment.carry_out(bench, measurements);
  } catch (const WorldLost&) {
    throw;
  } catch (const std::exception& failure) {
    for (const Property property : experiment.estimates) {
      measurements.fail(property, failure.what());
    }
  }
}

}  // namespace

const std::vector<Experiment>& allExperiments() {
  static const std::vector<Experiment> all = [] {
    std::vector<Experiment> result;
    // Shapes come early: later experiments put the pusher where it touches.
    for (const auto& area : {bookkeepingExperiments, actionExperiments, frameExperiments, servoExperiments,
                             shapeExperiments, wallExperiments, teeExperiments, contactExperiments}) {
      for (Experiment& experiment : area()) {
        experiment.needs_velocities |= area == actionExperiments || area == servoExperiments;
        result.push_back(std::move(experiment));
      }
    }
    return result;
  }();
  return all;
}

Measurements measure(Bench& bench) {
  Measurements measurements;
  try {
    for (const Experiment& experiment : allExperiments()) {
      carryOut(experiment, bench, measurements);
    }
  } catch (const WorldLost& loss) {
    for (const PropertyDescription& description : allProperties()) {
      measurements.fail(description.property, loss.what());
    }
  }
  return measurements;
}

}  // namespace sim2sim
