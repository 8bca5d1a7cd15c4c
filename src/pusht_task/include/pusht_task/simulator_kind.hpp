// SPDX-License-Identifier: BSD-3-Clause
/// A kind of simulator, described once: for its node, for runs in process, for whoever lists or shows it.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_task/batch_simulator.hpp"
#include "pusht_task/parameters.hpp"
#include "pusht_task/simulator.hpp"

namespace pusht {

/// A kind with values for its parameters, loaded and ready. Worlds of one model may step in different threads; they may
/// outlive it.
struct SimulatorModel {
  ParameterSet parameters;                               ///< as the kind understood them
  nlohmann::json provenance = nlohmann::json::object();  ///< what the numbers depend on besides, e.g. files
  std::function<std::unique_ptr<Simulator>()> make_world;
  std::function<std::unique_ptr<BatchSimulator>(int lanes)>
      make_lanes;  ///< as many worlds, each as make_world() has it
};

/// Description of a kind of simulator: its name, parameters and libraries, and how to load it.
struct SimulatorKind {
  std::string name;   ///< a word: "two_mass"
  std::string title;  ///< for people: "two-mass engine"
  std::string version;
  std::vector<ParameterDescriptor> parameters;
  /// Shared libraries, as "libpusht_engine.so", whose code decides what the worlds do, besides libm and pusht_task's.
  std::vector<std::string> libraries;
  /// [m, rad, m/s, rad/s] How near to where it was told to a world starts; its Simulator::startTolerance().
  double start_tolerance = kStartTolerance;
  /// Throws InvalidInput with parameter, value and rule for values that do not go together, or a file that is not
  /// right; BadDependency for what is missing.
  std::function<SimulatorModel(const ParameterSet&)> load;

  ParameterSet defaults() const { return ParameterSet(parameters); }
};

/// Kinds that can be chosen from by their names, which differ. They must outlive it.
using SimulatorKinds = std::vector<std::reference_wrapper<const SimulatorKind>>;

/// Names of the kinds, in their order.
std::vector<std::string> kindNames(const SimulatorKinds& kinds);

/// Throws InvalidInput, with the names that there are, if there is none of that `name`.
const SimulatorKind& kindNamed(const std::string& name, const SimulatorKinds& kinds);

/// Lanes of single worlds, one stepped after the other.
std::function<std::unique_ptr<BatchSimulator>(int lanes)> lanesOf(
    const std::function<std::unique_ptr<Simulator>()>& make_world);

}  // namespace pusht
