// SPDX-License-Identifier: BSD-3-Clause
/// Bench: one world under experiment, known by its interface alone.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

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
  /// Takes a control step with this commanded velocity [m/s]. Returns the reported state. Throws as Simulator::step().
  pusht::WorldState step(const Eigen::Vector2d& command);
  /// States reported after the reset and after each command.
  std::vector<pusht::WorldState> run(const pusht::WorldState& start, const std::vector<Eigen::Vector2d>& commands);

  /// Whether a world at rest in `state` moves when nothing is commanded, or refuses that start, as bodies do that
  /// overlap.
  bool isPushedApart(const pusht::WorldState& state);

  /// Another world of the same model; null if there is none.
  std::unique_ptr<pusht::Simulator> secondWorld() const { return make_second_ ? make_second_() : nullptr; }

  std::uint64_t seed() const { return seed_; }
  /// [m] Shift of the scenes of this seed.
  const Eigen::Vector2d& shift() const { return shift_; }
  /// [m, rad, m/s, rad/s] What the world says of itself.
  double startTolerance() const { return world_.startTolerance(); }

 private:
  pusht::Simulator& world_;
  WorldFactory make_second_;
  std::uint64_t seed_;
  Eigen::Vector2d shift_;
};

/// Least distance [m] from `center` along the unit vector `outward` at which the pusher, at rest, is not pushed away:
/// the place of a surface, by bisection to 0.1 um between `overlapping` and `apart` [m]. `scene` has the tee. None if
/// nothing is there. Throws std::runtime_error if the pusher is pushed even at `apart`.
std::optional<double> touchDistance(Bench& bench, const pusht::WorldState& scene, const Eigen::Vector2d& center,
                                    const Eigen::Vector2d& outward, double overlapping, double apart);

/// [m] Greatest distance of two states in positions, velocities over a control step, and yaw at the tee's size.
double distanceBetween(const pusht::WorldState& a, const pusht::WorldState& b);

}  // namespace sim2sim
