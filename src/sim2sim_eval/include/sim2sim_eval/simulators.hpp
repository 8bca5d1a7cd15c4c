// SPDX-License-Identifier: BSD-3-Clause
/// The simulators that run in process, by name.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pusht_task/simulator_kind.hpp"
#include "sim2sim_protocol/results/output_folder.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// The kinds that there are; the first is the course's reference, the second its engine.
const pusht::SimulatorKinds& simulatorKinds();

/// Names of all kinds, in their order.
std::vector<std::string> kindNames();

/// Throws as pusht::kindNamed.
const pusht::SimulatorKind& simulatorKind(const std::string& name);

/// A simulator that is asked for: a kind, and values for its parameters.
struct SimulatorChoice {
  std::reference_wrapper<const pusht::SimulatorKind> kind;
  pusht::ParameterSet parameters;
};

/// `settings` are "NAME=VALUE"; parameters that are not named have their defaults. Throws InvalidInput for an unknown
/// kind, a setting that is none or is given twice, and as ParameterSet::set.
SimulatorChoice chooseSimulator(const std::string& kind, const std::vector<std::string>& settings);

/// A simulator that is ready to run.
struct LoadedSimulator {
  /// Throws as SimulatorKind::load.
  explicit LoadedSimulator(const SimulatorChoice& choice) : kind(choice.kind), model(kind.load(choice.parameters)) {}

  SimulatorRecord record() const;

  /// What its numbers depend on besides, for provenance.json: the kind's "version" and what the model says.
  nlohmann::json provenance() const;

  /// The files that it has read.
  std::vector<Input> inputs() const;

  const pusht::SimulatorKind& kind;
  pusht::SimulatorModel model;
};

/// The files of a simulator's `provenance`: {PARAMETER: {"file": PATH, ...}, ...}.
std::vector<Input> filesIn(const nlohmann::json& provenance);

}  // namespace sim2sim
