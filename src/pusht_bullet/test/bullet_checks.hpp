// SPDX-License-Identifier: BSD-3-Clause
/// Physics that Bullet's worlds claim to have.
#pragma once

#include "pusht_testing/physics_of_kind.hpp"

namespace pusht::testing {

/// Claims of the kind with all its switches on. Gentle touches overlap by less than `overlap` [m].
inline PhysicsOfKind bulletPhysics(double overlap = 5e-4) {
  PhysicsOfKind physics;
  physics.replay_error = 0.15;
  physics.contact_position = overlap;
  return physics;
}

}  // namespace pusht::testing
