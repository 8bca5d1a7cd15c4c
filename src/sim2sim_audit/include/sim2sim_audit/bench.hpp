// SPDX-License-Identifier: BSD-3-Clause
/// Bench: one world under experiment, known by its interface alone.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/simulator.hpp"

namespace sim2sim {

/// Error: the world is gone for good, as a node that has died. No further experiment is carried out in it.
struct WorldLost : pusht::RuntimeFault {
  using RuntimeFault::RuntimeFault;
};

/// Maker of worlds of one model. Over nodes a second world takes the place of the first until it is destroyed.
using WorldFactory = std::function<std::unique_ptr<pusht::Simulator>()>;

/// One world under experiment.
class Bench {
 public:
  /// `world` must outlive the bench. `make_second` may be empty. `seed` moves the scenes of the experiments by at most
  /// kShift, so that no result hangs on one place.
  Bench(pusht::Simulator& world, WorldFactory make_second, std::uint64_t seed);

  static constexpr double kShift = 0.002;  ///< [m] per axis

  /// Sets the world to `state`. Returns the state that it reports. Throws as Simulator::reset().
  pusht::WorldState reset(const pusht::WorldState& state);
  /// Takes a control step with this commanded velocity [m/s]; in a task whose actions are positions, with the one at
  /// which the pusher goes on at that velocity for now. Returns the reported state. Throws as Simulator::step().
  pusht::WorldState step(const Eigen::Vector2d& command);
  /// States reported after the reset and after each command.
  std::vector<pusht::WorldState> run(const pusht::WorldState& start, const std::vector<Eigen::Vector2d>& commands);

  /// Whether a world at rest in `state` moves when nothing is commanded, or refuses that start, as bodies do that
  /// overlap.
  bool isPushedApart(const pusht::WorldState& state);

  /// Displacements of the bodies in a control step.
  struct Way {
    Eigen::Vector2d of_pusher;  ///< [m]
    double of_tee;              ///< [m]
  };
  /// Way from `start`, at rest, with the pusher commanded slowly along the unit vector `direction`: about 0.1 mm.
  Way slowWay(const pusht::WorldState& start, const Eigen::Vector2d& direction);
  /// Whether the pusher touches something where it is commanded slowly along `direction`: it goes otherwise than on
  /// the way `free`, or moves the tee.
  bool isHeld(const pusht::WorldState& state, const Eigen::Vector2d& direction, const Way& free);

  /// Another world of the same model; null if there is none.
  std::unique_ptr<pusht::Simulator> secondWorld() const { return make_second_ ? make_second_() : nullptr; }

  std::uint64_t seed() const { return seed_; }
  /// Task of the world, and its physics.
  const pusht::Task& task() const { return world_.task(); }
  const pusht::Physics& physics() const { return task().physics; }
  /// Whether actions are velocities, so that commands are forces: the servo's gain is the unit of what is measured.
  bool commandsVelocities() const { return physics().drive == pusht::Drive::kVelocity; }
  /// [m] By how much the walls are nearer than full_circle's, for which the scenes are made.
  double narrower() const { return pusht::kWallInnerFace - physics().wall_inner_face; }
  /// [m] Shift of the scenes of this seed.
  const Eigen::Vector2d& shift() const { return shift_; }
  /// [m, rad, m/s, rad/s] What the world says of itself.
  double startTolerance() const { return world_.startTolerance(); }

 private:
  pusht::WorldState reported();

  pusht::Simulator& world_;
  Eigen::Vector2d pusher_ = Eigen::Vector2d::Zero();  // [m] as reported last
  WorldFactory make_second_;
  std::uint64_t seed_;
  Eigen::Vector2d shift_;
};

/// Line along which the pusher is put nearer and nearer to a surface.
struct Approach {
  pusht::WorldState scene;  ///< has the tee
  Eigen::Vector2d center;   ///< [m] from where distances count
  Eigen::Vector2d outward;  ///< unit vector
  double overlapping;       ///< [m] distance at which bodies overlap
  double apart;             ///< [m] distance at which nothing touches

  pusht::WorldState at(double distance) const;
};

/// Distance [m] nearest to the surface at which the pusher, at rest, is not pushed away, by bisection to 0.1 um. None
/// if it is pushed nowhere. Throws std::runtime_error if it is pushed even apart.
std::optional<double> pushedDistance(Bench& bench, const Approach& approach);

/// Distance [m] at which the pusher, commanded slowly inwards, is held, to about 10 um. None if it is held nowhere.
std::optional<double> heldDistance(Bench& bench, const Approach& approach);

/// Place of a surface [m]: pushedDistance(), or heldDistance() in a world that leaves such overlaps alone. None if
/// nothing is there. Throws as pushedDistance().
std::optional<double> touchDistance(Bench& bench, const Approach& approach);

/// [m] Greatest distance of two states in positions, velocities over a control step, and yaw at the tee's size.
double distanceBetween(const pusht::WorldState& a, const pusht::WorldState& b);

}  // namespace sim2sim
