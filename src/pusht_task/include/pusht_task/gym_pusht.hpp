// SPDX-License-Identifier: BSD-3-Clause
/// gym-pusht's PushT (LeRobot; the environment of Diffusion Policy) as far as it is no physics: its units and frame,
/// its draws, its target, its reward. With 1 px = 1 mm tee and pusher have this suite's sizes.
/// Source: gym-pusht 0.1.5.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "pusht_task/coverage.hpp"
#include "pusht_task/types.hpp"

namespace pusht {
class Simulator;
}

namespace pusht::gym_pusht {

constexpr double kSide = 512.0;                ///< [px] of the window
constexpr double kPixelsPerMeter = 1000.0;     ///< [px/m]
constexpr double kBarCenter = 15.0;            ///< [px] from the tee's origin
constexpr double kCenterOfGravity = 45.0;      ///< [px] from the tee's origin, as gym-pusht has it; truly 40.714
constexpr double kWallMiddle = 255.5;          ///< [px] between the walls, on each axis
constexpr double kWallInnerFace = 248.5;       ///< [px] from there
constexpr double kSuccessCoverage = 0.95;      ///< [-] above it an episode ends in success
constexpr double kStiffness = 100.0;           ///< [1/s^2] of the pusher's controller, as an acceleration
constexpr double kDamping = 20.0;              ///< [1/s] likewise
constexpr std::uint64_t kFirstSeed = 100'000;  ///< of the episodes that Diffusion Policy is measured on

/// State in gym-pusht's units and frame: pixels from the upper left corner, y down; the tee's origin is the middle of
/// the bar's outer edge, angles turn clockwise as they are seen.
struct State {
  Eigen::Vector2d pusher = Eigen::Vector2d::Zero();           ///< [px]
  Eigen::Vector2d pusher_velocity = Eigen::Vector2d::Zero();  ///< [px/s]
  Eigen::Vector2d tee = Eigen::Vector2d::Zero();              ///< [px] of its origin
  double angle = 0.0;                                         ///< [rad] not wrapped, unless it was in a WorldState
  Eigen::Vector2d tee_velocity = Eigen::Vector2d::Zero();     ///< [px/s] of its center of gravity
  double rate = 0.0;                                          ///< [rad/s]
};

/// State in the table's frame, whose origin is the window's middle. The angle is wrapped. `center_of_gravity`: px
/// from the tee's origin.
WorldState toTable(const State& state, double center_of_gravity = kCenterOfGravity);

/// State of the table in gym-pusht's frame. fromTable(toTable(s)) is s to 1e-12 px and the turns of its angle.
State fromTable(const WorldState& state, double center_of_gravity = kCenterOfGravity);

/// Draw of gym-pusht for an episode, as `reset(seed=...)` makes it up to 0.1.5 and then asks the world to be in.
/// Bodies may overlap.
State drawn(std::uint32_t seed);

/// State after a reset to `asked`. gym-pusht sets the tee's position, then turns it about its
/// center of gravity, so that its origin moves.
State turned(const State& asked, double center_of_gravity = kCenterOfGravity);

constexpr std::size_t kCorners = 8;
constexpr std::size_t kScattered = 9;

/// [px] Corners of the tee's bar, then of its stem, in the order in which gym-pusht's observation has them, to the last
/// bit.
std::array<Eigen::Vector2d, kCorners> keypoints(const State& state);

/// [px] Points of the tee that Diffusion Policy's policies see: of all pixels of its picture, the ones that are
/// farthest from each other, from a drawn one on, each moved by less than a pixel. Source: Diffusion Policy, its
/// keypoint manager with seed 0; computed with numpy 1.24 and pygame 2.1.
std::array<Eigen::Vector2d, kScattered> scatteredKeypoints(const State& state);

/// What gym-pusht's environment lets its users change in its world.
struct Variant {
  std::optional<Eigen::Vector2d> block_cog{};  ///< [px] center of gravity from the tee's origin; none: its own
  std::optional<double> damping{};             ///< [-] share of the tee's velocity left after a second; none: its own
};

/// World in gym-pusht's units, with its resets.
class World {
 public:
  World() = default;
  World(const World&) = delete;
  World& operator=(const World&) = delete;
  virtual ~World() = default;

  /// What gym-pusht's `reset(options={"reset_to_state": ...})` does: `asked` has positions and the angle; its
  /// velocities are not read.
  virtual void reset(const State& asked) = 0;

  /// Takes a control step towards `target` [px], which is not clipped.
  virtual void step(const Eigen::Vector2d& target) = 0;

  /// State of the world. Its angle is wrapped in a world that wraps it, as other engines' do.
  virtual State state() const = 0;

  /// [rad] The tee's angle with the turns that it has made, and those of its start.
  virtual double unwrappedAngle() const { return state().angle; }

  /// Contact points of the tee, summed over the substeps of the latest step or reset.
  virtual int contacts() const = 0;
};

/// World of another engine, in the task gym_pusht, as gym-pusht's environment would show it: a reset puts the bodies
/// where gym-pusht's has them before its first substep, and of contacts it knows whether pusher and tee touch after a
/// step. Its state has the bits of the simulator's, by fromTable(), so the angle is wrapped.
std::unique_ptr<World> inPixels(std::unique_ptr<Simulator> simulator);

}  // namespace pusht::gym_pusht
