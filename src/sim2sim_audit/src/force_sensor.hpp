// SPDX-License-Identifier: BSD-3-Clause
/// The pusher as a force sensor.
#pragma once

#include <Eigen/Core>

#include "pusht_task/types.hpp"
#include "sim2sim_audit/measurements.hpp"

namespace sim2sim {

/// Impulses that contacts took from the pusher, from the balance of its momentum: what its servo and damping gave less
/// what it has kept. In units of the servo's gain [m], because no motion shows absolute forces. Below the servo's limit
/// the balance is exact for a linear servo, whatever happens within the control steps.
class ForceSensor {
 public:
  /// Throws std::runtime_error if the servo is not known.
  explicit ForceSensor(const Measurements& found)
      : damping_(1.0 + found.need(Property::kPusherDamping)),
        mass_(found.need(Property::kPusherMass)),
        scale_(found.need(Property::kActionScaleX), found.need(Property::kActionScaleY)) {}

  /// [-] Steady speed over command of the servo alone.
  double gainShare() const { return 1.0 / damping_; }

  /// [m] Impulse over gain, between two states that are a control step apart.
  Eigen::Vector2d impulse(const pusht::WorldState& from, const pusht::WorldState& to,
                          const Eigen::Vector2d& command) const;

 private:
  double damping_;         ///< [-] gain and damping over the gain
  double mass_;            ///< [s] mass over the gain
  Eigen::Vector2d scale_;  ///< [-] of commands
};

}  // namespace sim2sim
