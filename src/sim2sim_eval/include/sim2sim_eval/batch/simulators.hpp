// SPDX-License-Identifier: BSD-3-Clause
/// Simulators of a run in one process.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pusht_task/loop.hpp"
#include "pusht_task/simulator_kind.hpp"
#include "sim2sim_protocol/results/output_folder.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_serving/served_kind.hpp"

namespace sim2sim {

/// Kind whose code is in no library of a workspace: what a node serves, or a program in Python makes.
struct ForeignKind {
  std::string name;  ///< by which it is asked for: "node:/engine", "python:mine"
  pusht::SimulatorKind kind;
  nlohmann::json code;     ///< what is known of its code, in place of a fingerprint
  bool one_world = false;  ///< whether there is only one world of it
};

/// Makes a kind of this program known by its name "python:NAME", while the result lives.
std::shared_ptr<const ForeignKind> lend(ForeignKind kind);

/// Time limits of the nodes that the command under way asks for.
pusht::NodeTimes& nodeTimes();

/// A simulator that is asked for: a kind, values for its parameters, and the loop in which a policy drives it.
struct SimulatorChoice {
  std::reference_wrapper<const pusht::SimulatorKind> kind;
  pusht::ParameterSet parameters;
  pusht::ParameterSet loop = pusht::plainLoop();
  std::shared_ptr<const ForeignKind> foreign{};  ///< owner of the kind; null: an installed one
  std::reference_wrapper<const pusht::Task> task = pusht::fullCircle();

  /// Name by which the kind is asked for.
  const std::string& name() const { return foreign ? foreign->name : kind.get().name; }

  /// Sets a parameter of the simulator, or of the loop: "loop.action_delay". Throws as ParameterSet::set().
  void set(const std::string& name, const std::string& text);

  /// Parameter of either. Throws as ParameterSet::at().
  const pusht::Parameter& at(const std::string& name) const;

  /// Names for at(): all parameters of the simulator, and those of the loop that were set.
  std::vector<std::string> names() const;
};

/// `kind` names an installed kind, one that was lent, or with "node:/NAME" the simulator that a node serves; choices of
/// one node share its connection. `settings` are "NAME=VALUE"; parameters that are not named have their defaults.
/// Throws as SimulatorKinds::named, pusht::servedKind and ParameterSet::set; InvalidInput for a setting that is none or
/// is given twice.
SimulatorChoice chooseSimulator(const std::string& kind, const std::vector<std::string>& settings);

/// Engine of a run that has none (kNoEngine): a kind without worlds.
SimulatorChoice noEngine();

/// Simulator that "KIND" or "KIND:NAME=VALUE:NAME=VALUE" asks for. Throws as chooseSimulator().
SimulatorChoice simulatorFromText(const std::string& text);

/// Whether kind, values and loop are the same, however they were set.
bool operator==(const SimulatorChoice& a, const SimulatorChoice& b);

/// Fewest settings with which chooseSimulator() makes `simulator` from its kind: presets, and what differs from them.
std::vector<std::string> settingsOf(const SimulatorChoice& simulator);

/// Shortest text that simulatorFromText() reads as `simulator`: its kind, presets, and what differs from them. Equal
/// simulators have equal texts, however they were set.
std::string textOf(const SimulatorChoice& simulator);

/// Throws InvalidInput if both are one foreign kind with one world.
void requireTwoWorlds(const SimulatorChoice& reference, const SimulatorChoice& engine);

/// Sets the task of simulators. Throws InvalidInput if one of their kinds does not hold it.
void setTask(const pusht::Task& task, const std::vector<std::reference_wrapper<SimulatorChoice>>& simulators);

/// Throws InvalidInput if `simulator` is asked for with a loop: `command` has no policy in a loop.
void requireNoLoop(const SimulatorChoice& simulator, const std::string& command);

/// A simulator that is ready to run.
struct LoadedSimulator {
  /// Throws as SimulatorKind::load().
  explicit LoadedSimulator(const SimulatorChoice& choice);

  /// Record of the simulator and of the loop in which a policy drives it.
  SimulatorRecord record() const;

  /// Record of the simulator alone.
  SimulatorRecord simulatorRecord() const;

  /// What its numbers depend on besides, for provenance.json: the kind's "version" and what the model says.
  nlohmann::json provenance() const;

  /// The files that it has read.
  std::vector<Input> inputs() const;

  bool hasOneWorld() const { return foreign && foreign->one_world; }

  std::shared_ptr<const ForeignKind> foreign;  ///< owner of the kind; null: an installed one
  const pusht::SimulatorKind& kind;
  const pusht::Task& task;
  pusht::SimulatorModel model;
  pusht::ParameterSet loop;
};

}  // namespace sim2sim
