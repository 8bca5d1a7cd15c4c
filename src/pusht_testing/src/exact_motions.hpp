// SPDX-License-Identifier: BSD-3-Clause
/// Motions whose end is known without a substep: by a closed form, or as the solution of an ordinary differential
/// equation to a tolerance far below every error that is measured against it. convergence_suite.cpp holds kinds of
/// simulators against them.
#pragma once

#include <optional>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/types.hpp"
#include "pusht_testing/physics_of_kind.hpp"

namespace pusht::testing {

/// Motion under one action, and where it ends. Velocities at the end are not said.
struct ExactMotion {
  WorldState start;
  Action action;
  int control_steps;
  WorldState end;

  double duration() const { return control_steps * kControlStep; }  ///< [s]
};

/// Motion with its name in claims and reports; none for a kind that lacks it.
struct NamedExactMotion {
  const char* name;
  std::optional<ExactMotion> (*make)(const PhysicsOfKind& physics);
};

/// Every exact motion.
const std::vector<NamedExactMotion>& exactMotions();

}  // namespace pusht::testing
