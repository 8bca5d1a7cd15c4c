// SPDX-License-Identifier: BSD-3-Clause
/// Numbers of a task's physics as parameters of a kind of simulator, each with one name for all kinds.
#pragma once

#include <string>
#include <vector>

#include "pusht_task/parameters.hpp"
#include "pusht_task/physics.hpp"

namespace pusht {

/// Number of Physics that a kind may have as a parameter.
struct PhysicsNumber {
  ParameterDescriptor descriptor;  ///< its default is full_circle's
  double (*of)(const Physics& physics);
  void (*set)(Physics& physics, double value);
};

/// All of them, in the order in which kinds have them.
const std::vector<PhysicsNumber>& physicsNumbers();

/// Descriptor of the number of this name. Throws InternalError if there is none.
const ParameterDescriptor& physicsDescriptor(const std::string& name);

/// Descriptors of all, for a kind whose results have a number only if it is changed.
std::vector<ParameterDescriptor> physicsDescriptors();

/// `physics` with the numbers of `set`, which has all, that differ from their defaults.
Physics physicsWith(const ParameterSet& set, Physics physics);

}  // namespace pusht
