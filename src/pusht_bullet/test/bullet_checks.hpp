// SPDX-License-Identifier: BSD-3-Clause
/// Physics that Bullet's worlds claim to have, and which checks of the physics suite find something else in a world.
#pragma once

#include <string>
#include <vector>

#include "pusht_task/simulator.hpp"
#include "pusht_task/testing/physics_checks.hpp"
#include "pusht_task/testing/physics_of_kind.hpp"

namespace pusht::testing {

/// Claims of the kind with all its switches on. Gentle touches overlap by less than `overlap` [m].
inline PhysicsOfKind bulletPhysics(double overlap = 5e-4) {
  PhysicsOfKind physics;
  physics.replay_error = 0.15;
  physics.contact_position = overlap;
  return physics;
}

/// Names of the checks that find an error.
inline std::vector<std::string> findingsIn(Simulator& world) {
  std::vector<std::string> names;
  for (const NamedPhysicsCheck& named : kPhysicsChecks) {
    if (!named.check(world, bulletPhysics()).list().empty()) {
      names.emplace_back(named.name);
    }
  }
  return names;
}

}  // namespace pusht::testing
