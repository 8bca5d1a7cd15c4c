// SPDX-License-Identifier: BSD-3-Clause
/// gym-pusht's world, to the last bit, in its own units (pusht_task/gym_pusht.hpp).
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>

#include "pusht_task/gym_pusht.hpp"
#include "pusht_task/switches.hpp"

namespace pusht {

/// Quirks of gym-pusht: each is there (true), or as it would be in a sound world.
struct GymPushtQuirks {
  bool inertia = true;
  bool center = true;
  bool contact_friction = true;
  bool coasting = true;
  bool kinematic = true;
};

/// Quirks of its resets, likewise.
struct GymPushtResets {
  bool legacy_order = true;  ///< sets the tee's position, then turns it about its center of gravity; sound: turns first
  bool first_substep = true;  ///< ends with a substep, so that overlapping bodies are pushed apart from the next one on
};

/// World of gym-pusht 0.1.5 on pymunk 6.6, whose space, bodies and shapes it makes in the same order and drives by the
/// same arithmetic. Every reset makes a new space, as gym-pusht's does. Not thread-safe.
class GymPushtWorld final : public gym_pusht::World {
 public:
  /// Descriptions of all quirks.
  static constexpr std::array kQuirks = {
      Switch<GymPushtQuirks>{"inertia",
                             "the tee's moment of inertia is 3000 px^2, twice that of its bar about the origin; sound: "
                             "1931.6 px^2, that of a uniform tee",
                             &GymPushtQuirks::inertia},
      Switch<GymPushtQuirks>{"center",
                             "the tee's center of gravity is the mean of its parts' centers, without their areas, 45 "
                             "px from its origin; sound: 40.7 px",
                             &GymPushtQuirks::center},
      Switch<GymPushtQuirks>{"contact_friction",
                             "contacts have no friction, as it is set where it has no effect; sound: 1",
                             &GymPushtQuirks::contact_friction},
      Switch<GymPushtQuirks>{"coasting", "the tee's velocity is wiped in each substep; sound: it is damped, at 38 1/s",
                             &GymPushtQuirks::coasting},
      Switch<GymPushtQuirks>{"kinematic",
                             "the pusher feels no force, and walls do not stop it; sound: it has a mass of 2 kg, and "
                             "its drive a limit of 300 N",
                             &GymPushtQuirks::kinematic},
  };

  explicit GymPushtWorld(const GymPushtQuirks& quirks = {}, const GymPushtResets& resets = {},
                         const gym_pusht::Variant& variant = {});
  ~GymPushtWorld() override;

  void reset(const gym_pusht::State& asked) override;

  /// Puts the bodies where they are in `state`. A world at rest takes the substep of a reset, in which nothing moves,
  /// but after which bodies that overlap are pushed apart.
  void restore(const gym_pusht::State& state);

  void step(const Eigen::Vector2d& target) override;

  gym_pusht::State state() const override;

  int contacts() const override;

  /// [px] From the tee's origin to its center of gravity.
  double centerOfGravity() const;

 private:
  class Space;

  GymPushtQuirks quirks_;
  GymPushtResets resets_;
  gym_pusht::Variant variant_;
  std::unique_ptr<Space> space_;
  int contacts_ = 0;
};

}  // namespace pusht
