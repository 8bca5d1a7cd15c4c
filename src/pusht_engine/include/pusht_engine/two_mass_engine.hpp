// SPDX-License-Identifier: BSD-3-Clause
/// The baseline engine: the tee as two point masses on a rigid link, a disc that pushes it.
#pragma once

#include "pusht_engine/two_mass_dynamics.hpp"
#include "pusht_task/simulator.hpp"

namespace pusht {

/// The knobs.
struct TwoMassParameters {
  double pusher_mass = 4.0;  ///< [kg] inertia of the pusher in contact
  double block_damp = 6.0;   ///< [1/s] viscous drag rate of both masses, in place of table friction
  double baumgarte = 40.0;   ///< [rad/s] stabilisation frequency of the link

  /// Throws InvalidInput with knob, value and rule.
  void validate() const;
};

/// No walls, no friction, no continuous collision: its simplifications are the point.
class TwoMassEngine : public Simulator {
 public:
  /// Throws InvalidInput if a knob is out of range.
  explicit TwoMassEngine(const TwoMassParameters& parameters = {});

  const two_mass::BodyVectors& positions() const { return positions_; }
  const two_mass::BodyVectors& velocities() const { return velocities_; }

 private:
  void doReset(const WorldState& state) override;
  void doStep(const Action& action) override;
  WorldState doState() const override;

  void substep(const Eigen::Vector2d& command);

  TwoMassParameters parameters_;
  two_mass::BodyScalars masses_;
  two_mass::BodyScalars inverse_masses_;
  two_mass::BodyVectors positions_;
  two_mass::BodyVectors velocities_;
};

}  // namespace pusht
