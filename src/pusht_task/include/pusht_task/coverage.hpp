// SPDX-License-Identifier: BSD-3-Clause
/// Coverage: the share of the target's area that the tee covers, by which gym-pusht and Diffusion Policy judge a state.
#pragma once

#include <Eigen/Core>

#include "pusht_task/physics.hpp"

namespace pusht {

/// Pose on the table.
struct Pose {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< [m] of the tee origin
  double yaw = 0.0;                                    ///< [rad]
};

/// [-] Share of a tee at `target` that a tee at `tee` covers, in [0, 1]. Both have the sizes of `physics`, whose bar
/// and stem must not overlap.
double coverageOf(const Pose& tee, const Pose& target, const Physics& physics = {});

}  // namespace pusht
