// SPDX-License-Identifier: BSD-3-Clause
/// Simulators in which demonstrations take place, with parameters that are drawn for each of them (domain
/// randomization).
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_policy/demonstrations.hpp"
#include "sim2sim_eval/batch/simulators.hpp"

namespace sim2sim {

/// Parameter that is drawn for each demonstration: uniformly between two values, both included; of the numbers between
/// them, if its kind takes only some numbers.
struct Draw {
  std::string parameter;
  pusht::ParameterValue least;
  pusht::ParameterValue greatest;

  /// Value for the demonstration from this spawn seed, as text. It depends on nothing but the seed, `kind`, and the
  /// draw.
  std::string value(std::uint64_t seed, const pusht::SimulatorKind& kind) const;
};

/// Simulators that take turns: the demonstration from spawn seed s is in simulator s mod n, whatever its number in the
/// bag. So bags of neighboring seeds join to the one bag of all of them.
class DemonstrationSimulators {
 public:
  /// `simulators` are "KIND" or "KIND:NAME=VALUE:...", each once; a VALUE may be LEAST..GREATEST, to be drawn.
  /// `settings`, "NAME=VALUE", belong to the only simulator. Throws InvalidInput for a kind, a name or a value that
  /// does not exist, a parameter that is given twice, settings if there are several simulators, or a range of a
  /// parameter that is no number; as setTask() and SimulatorKind::load.
  DemonstrationSimulators(const std::vector<std::string>& simulators, const std::vector<std::string>& settings,
                          const pusht::Task& task = pusht::fullCircle());

  /// World of the demonstration from this spawn seed. Throws as SimulatorKind::load, naming the seed, for drawn values
  /// that exclude each other.
  pusht::DemonstrationWorld worldOf(std::uint64_t seed);

  /// All simulators, for the bag's origin: kind, version, files, parameters that do not have their defaults, and the
  /// ranges of those that are drawn.
  nlohmann::json description() const;

 private:
  struct Entry {
    std::string name;  // as a plan has it, without what is drawn: "mujoco:timestep=0.005"
    LoadedSimulator simulator;
    std::vector<Draw> draws;
    std::shared_ptr<pusht::Simulator> world;  // for all demonstrations, if nothing is drawn
  };

  const pusht::Task* task_;
  std::vector<Entry> entries_;
};

}  // namespace sim2sim
