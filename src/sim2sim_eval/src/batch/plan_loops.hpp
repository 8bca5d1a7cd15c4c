// SPDX-License-Identifier: BSD-3-Clause
/// Loops between policy and world that a plan of a sweep names. Private to plans.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <utility>
#include <vector>

#include "sim2sim_eval/batch/simulators.hpp"

namespace sim2sim {

/// Names and values of the parameters of a loop.
using LoopSettings = std::vector<std::pair<std::string, std::string>>;

struct PlannedLoop {
  LoopSettings settings;
  YAML::Node node;  ///< where the plan has it, for messages
};

/// Loops of a plan; without any the one of each simulator itself. Throws InvalidInput with line and rule.
std::vector<PlannedLoop> loopsIn(const YAML::Node& root);

/// `simulator` in `loop`, which is one of `loops`: it names the parameters of all of them, so that the rows of a sweep
/// have the same ones. Throws InvalidInput, in the line of the loop, for a parameter that the simulator has in the plan
/// already.
SimulatorChoice inLoop(SimulatorChoice simulator, const PlannedLoop& loop, const std::vector<PlannedLoop>& loops);

}  // namespace sim2sim
