// SPDX-License-Identifier: BSD-3-Clause
/// Kind of simulator, described once for its node, for runs in process, and for lists and results.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "pusht_task/batch_simulator.hpp"
#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/parameters.hpp"
#include "pusht_task/simulator.hpp"

namespace pusht {

/// Model: a kind with values for its parameters, loaded and ready to make worlds. Worlds of one model may be made
/// and stepped in different threads at once, and may outlive it.
struct SimulatorModel {
  ParameterSet parameters;                               ///< parameters as the kind has read them
  nlohmann::json provenance = nlohmann::json::object();  ///< all else that the numbers depend on, e.g. files
  std::function<std::unique_ptr<Simulator>()> make_world;
  std::function<std::unique_ptr<BatchSimulator>(int lanes)>
      make_lanes;  ///< makes a batch of so many worlds, each as from make_world()
  /// Makes a world with the bits of gym-pusht's own; null: the kind has none.
  std::function<std::unique_ptr<gym_pusht::World>(const gym_pusht::Variant&)> make_in_pixels{};
};

/// Function that loads a model with values for its parameters, for a task. A kind of one task may leave the task out:
/// any function of a ParameterSet is a loader, too.
class ModelLoader {
 public:
  ModelLoader() = default;
  template <class Function, class = std::enable_if_t<!std::is_same_v<std::decay_t<Function>, ModelLoader>>>
  ModelLoader(Function load) {  // NOLINT(google-explicit-constructor): as std::function
    if constexpr (std::is_invocable_v<Function, const ParameterSet&, const Task&>) {
      load_ = std::move(load);
    } else {
      load_ = [load = std::move(load)](const ParameterSet& set, const Task& /*task*/) { return load(set); };
    }
  }

  SimulatorModel operator()(const ParameterSet& set, const Task& task) const { return load_(set, task); }

 private:
  std::function<SimulatorModel(const ParameterSet&, const Task&)> load_;
};

/// Description of a kind of simulator: its name, parameters and libraries, and how to load it.
struct SimulatorKind {
  std::string name;     ///< key: "two_mass"
  std::string title;    ///< for people: "two-mass engine"
  std::string version;  ///< of the engine's library, as loaded
  std::vector<ParameterDescriptor> parameters;
  /// Shared libraries whose code decides what the worlds do, such as "libchipmunk.so". libm and pusht_task's are taken
  /// for granted. SimulatorKinds adds the kind's own.
  std::vector<std::string> libraries;
  /// Maximum deviation of the state after a reset from the requested state [m, rad, m/s, rad/s]; its worlds'
  /// Simulator::startTolerance().
  double start_tolerance = kStartTolerance;
  /// Loads a model with these values, for a task that it holds; callers use load(). Throws InvalidInput with parameter,
  /// value and rule for values that exclude each other or a file that is not valid; BadDependency for a file or library
  /// that is missing.
  ModelLoader loader;
  /// Default model variants: the same physics by other numerics, such as "timestep=0.005" or, with several parameters,
  /// "cone=elliptic:impratio=10.0". They tell how far the kind is from itself.
  std::vector<std::string> variants{};
  /// What worlds with default parameters do otherwise than the task on purpose: keys of properties of an audit, such as
  /// "tee_friction_x".
  std::vector<std::string> departures{};
  /// Names of the tasks that it holds; empty: all, as it builds its worlds from the task's data.
  std::vector<std::string> tasks = {fullCircle().name};

  /// Throws InvalidInput if it does not hold the task.
  void requireTask(const Task& task) const;

  /// A task that it holds: full_circle, if it does.
  const Task& ownTask() const;

  /// Parameters with their defaults. Those that are numbers of the task (physics_numbers.hpp) have the task's.
  ParameterSet defaults(const Task& task = fullCircle()) const;

  /// `set`, whose numbers of the task are this one's, unless they were set by name.
  ParameterSet inTask(ParameterSet set, const Task& task) const;

  /// Model with these values, for a task. Throws InvalidInput if the kind does not hold the task, and as `loader`.
  SimulatorModel load(const ParameterSet& set, const Task& task = fullCircle()) const;
};

/// Model of a kind that has no batch of its own: the worlds of a batch are single ones, which step one after the other.
SimulatorModel modelOfWorlds(ParameterSet parameters, std::function<std::unique_ptr<Simulator>()> make_world);

}  // namespace pusht
