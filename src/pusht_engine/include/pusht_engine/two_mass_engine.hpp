// SPDX-License-Identifier: BSD-3-Clause
/// The baseline engine: the tee as two point masses on a rigid link, a disc that pushes it.
#pragma once

#include <array>

#include "pusht_engine/two_mass_dynamics.hpp"
#include "pusht_task/simulator.hpp"

namespace pusht {

/// The knobs; two_mass::kKnobs says what they mean.
struct TwoMassParameters {
  double pusher_mass = 4.0;  ///< [kg]
  double block_damp = 6.0;   ///< [1/s]
  double baumgarte = 40.0;   ///< [rad/s]

  /// Throws InvalidInput with knob, value and rule.
  void validate() const;
};

namespace two_mass {

/// A knob, for whoever sets or shows it by name.
struct Knob {
  const char* name;
  const char* unit;
  const char* meaning;
  double TwoMassParameters::*value;
};

/// All of them, in the order in which the course's configuration hash has them.
constexpr std::array<Knob, 3> kKnobs = {{
    {"pusher_mass", "kg", "inertia of the pusher in contact", &TwoMassParameters::pusher_mass},
    {"block_damp", "1/s", "viscous drag rate of the tee, in place of table friction", &TwoMassParameters::block_damp},
    {"baumgarte", "rad/s", "stabilisation frequency of the tee's link", &TwoMassParameters::baumgarte},
}};

}  // namespace two_mass

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
