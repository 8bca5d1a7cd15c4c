// SPDX-License-Identifier: BSD-3-Clause
/// Faults to be planted in worlds of three kinds, each with the properties that name it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim2sim_audit/audit.hpp"
#include "sim2sim_audit/property.hpp"

namespace sim2sim::testing {

/// Fault, and how to plant it. A kind without a maker cannot have it without being another program.
struct PlantedFault {
  std::string name;
  std::vector<Property> named_by;  ///< more than one: properties that cannot be told apart, or of which each is right
  WorldFactory in_mujoco;
  WorldFactory in_chipmunk;
  WorldFactory in_rigid_body;
};

/// Faults at the interface: what a world makes of starts, states and commands.
std::vector<PlantedFault> interfaceFaults();

/// All faults.
std::vector<PlantedFault> plantedFaults();

/// What an audit finds in a world.
Measurements measured(const WorldFactory& make, std::uint64_t seed = 0);

/// Worlds without a fault.
WorldFactory cleanMujoco();
WorldFactory cleanChipmunk();
WorldFactory cleanRigidBody();

}  // namespace sim2sim::testing
