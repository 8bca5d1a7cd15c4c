// SPDX-License-Identifier: BSD-3-Clause
/// The baseline engine: the tee as two point masses on a rigid link, a disc that pushes it.
#pragma once

#include <array>
#include <exception>
#include <vector>

#include "pusht_engine/two_mass_dynamics.hpp"
#include "pusht_task/batch_simulator.hpp"
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

  const two_mass::Bodies<double>& bodies() const { return bodies_; }

 private:
  void doReset(const WorldState& state) override;
  void doStep(const Action& action) override;
  WorldState doState() const override;

  two_mass::Model model_;
  two_mass::Bodies<double> bodies_;
};

/// The same engine for many worlds: they step together in SIMD lanes.
class TwoMassLanes : public BatchSimulator {
 public:
  /// Throws InvalidInput if a knob is out of range.
  TwoMassLanes(int lanes, const TwoMassParameters& parameters = {});

  int lanes() const override { return static_cast<int>(states_.size()); }
  void reset(int lane, const WorldState& state) override;
  void step(Actions actions) override;
  WorldState state(int lane) const override;

 private:
  using Group = two_mass::Bodies<two_mass::Lanes>;

  void stepGroup(std::size_t group, Actions actions);

  two_mass::Model model_;
  std::vector<Group> groups_;  // lane i is lane i % kLaneCount of group i / kLaneCount
  std::vector<WorldState> states_;
  std::vector<std::exception_ptr> errors_;  // why a lane must be reset before it can go on
};

}  // namespace pusht
