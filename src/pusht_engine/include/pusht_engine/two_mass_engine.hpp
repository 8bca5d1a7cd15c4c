// SPDX-License-Identifier: BSD-3-Clause
/// The baseline engine: the tee as two point masses on a rigid link, a disc that pushes it.
#pragma once

#include <array>
#include <exception>
#include <vector>

#include "pusht_engine/two_mass_dynamics.hpp"
#include "pusht_task/batch_simulator.hpp"
#include "pusht_task/parameters.hpp"
#include "pusht_task/simulator.hpp"

namespace pusht {

/// The knobs; two_mass::kKnobs says what they mean.
struct TwoMassParameters {
  double pusher_mass = 4.0;  ///< [kg]
  double block_damp = 6.0;   ///< [1/s]
  double baumgarte = 40.0;   ///< [rad/s]

  /// Throws InvalidInput with knob, value, rule and reason, if a substep with them is not stable.
  void validate() const;
};

namespace two_mass {

/// A knob, for whoever sets or shows it by name.
struct Knob {
  const char* name;
  const char* unit;
  const char* meaning;
  double TwoMassParameters::*value;
  double least;
  double greatest;
  const char* reason;  ///< why the range ends where it does

  ParameterDescriptor descriptor() const;
};

/// All of them, in the order in which the course's configuration hash has them. The ranges, with h = kSubstep:
/// - pusher_mass: any is stable. The servo does not know it, and contact sweeps shrink what is left of the overlap by
///   (n1.n2)^2 m1 m2 / ((m1 + M)(m2 + M)) < 0.006 each, as both normals are nearly at right angles. Beyond the range
///   nothing changes any more: the pusher has no inertia, or the tee has none.
/// - block_damp: a substep multiplies the velocity by 1 - h block_damp, which must not be negative.
/// - baumgarte: pushed at v = 1 m/s, the link gives way by up to 0.58 v / baumgarte; that is its length at 9.7.
///   Overlap adds to v: up to about 20, a hard push may still close it. The world then flies apart, which ends the
///   run. The upper end is greatestBaumgarte(0).
constexpr std::array<Knob, 3> kKnobs = {{
    {"pusher_mass", "kg", "inertia of the pusher in contact", &TwoMassParameters::pusher_mass, 1e-6, 1e6,
     "beyond that nothing changes"},
    {"block_damp", "1/s", "viscous drag rate of the tee, in place of table friction", &TwoMassParameters::block_damp,
     0.0, 100.0, "more would turn the velocity round in every substep"},
    {"baumgarte", "rad/s", "stabilisation frequency of the tee's link", &TwoMassParameters::baumgarte, 10.0, 82.8,
     "a softer link closes under a push, a stiffer one shakes itself apart"},
}};

/// [rad/s] The stiffest link that is stable with this drag [1/s]. With x = h baumgarte and c = h block_damp, a small
/// error e of its length and the rate u go as u' = (1 - 2x - c) u - (x^2 / h) e, e' = e + h u'. The eigenvalues are
/// inside the unit circle if x^2 + 4x + 2c < 4 (Jury's criterion).
double greatestBaumgarte(double block_damp);

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
