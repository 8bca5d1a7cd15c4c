// SPDX-License-Identifier: BSD-3-Clause
/// Tasks: what all simulators must agree on, as data, and the rules that follow from it. No physics happens here.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pusht_task/constants.hpp"
#include "pusht_task/coverage.hpp"
#include "pusht_task/physics.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

/// Units and frame of a task's own, in which its policies see and act. Poses of the tee are those of the task's own
/// origin of it, which lies on the bar's axis of symmetry.
struct TaskFrame {
  std::string unit = "m";
  double per_meter = 1.0;                            ///< [unit/m]
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< [unit] of the table frame's origin
  bool y_down = false;                               ///< y and angles run the other way
  double bar_center = 0.0;                           ///< [unit] of the bar's center from the tee's origin, to the stem

  /// Whether it is the table frame.
  bool isTables() const;
  /// Direction or velocity of this frame in the table frame [m, m/s].
  Eigen::Vector2d vectorToTable(const Eigen::Vector2d& vector) const;
  /// Direction or velocity of the table frame in this one [unit, unit/s].
  Eigen::Vector2d vectorFromTable(const Eigen::Vector2d& vector) const;
  /// Point of this frame in the table frame [m].
  Eigen::Vector2d pointToTable(const Eigen::Vector2d& point) const;
  /// Point of the table frame in this one [unit].
  Eigen::Vector2d pointFromTable(const Eigen::Vector2d& point) const;
  /// Pose of the tee of this frame in the table frame [m, rad]; the yaw is wrapped.
  Pose poseToTable(const Pose& pose) const;
  /// Pose of the tee of the table frame in this one [unit, rad].
  Pose poseFromTable(const Pose& pose) const;

 private:
  Eigen::Vector2d flipped(const Eigen::Vector2d& vector) const;
};

/// When a state counts as solved.
struct SuccessRule {
  double position_tolerance = kPositionTolerance;  ///< [m] of the tee's origin, below it
  double angle_tolerance = kAngleTolerance;        ///< [rad] below it
  std::optional<double> coverage{};                ///< [-] above it, in place of the tolerances
  int hold = kSuccessHold;                         ///< consecutive control steps for success
};

/// How initial states are drawn from a spawn seed.
enum class SpawnRule {
  kRing,      ///< the tee on a ring around the target, the pusher clear of it
  kGymPusht,  ///< gym-pusht's draws, as its resets leave them; bodies may overlap
};

/// Ring around the target from which tees are drawn, and where the pusher may be.
struct SpawnRing {
  double least_radius = kSpawnRadiusMin;            ///< [m]
  double greatest_radius = kSpawnRadiusMax;         ///< [m]
  double pusher_bound = kSpawnPusherBound;          ///< [m] per axis, from the walls' middle
  double pusher_clearance = kSpawnPusherClearance;  ///< [m] from the tee origin
};

/// A task: sizes, forces, walls, target, what an action and an observation are, when it is solved, where episodes
/// start. A run has one, from which all its numbers are taken.
struct Task {
  std::string name;                     ///< key: "full_circle"
  Physics physics{};                    ///< of a sound world
  Pose target{};                        ///< in the table frame
  TaskFrame frame{};                    ///< of observations and actions
  std::optional<float> action_limit{};  ///< [m/s, or unit of the frame] per axis; none: actions are not clipped
  SuccessRule success{};
  SpawnRule spawn = SpawnRule::kRing;
  SpawnRing ring{};
  std::uint64_t first_spawn_seed = kFirstSpawnSeed;  ///< of the episodes of a run with seed 0
  std::uint64_t last_spawn_seed = UINT64_MAX;
};

/// The course's task, the default.
const Task& fullCircle();

/// gym-pusht's task. Actions are target positions of the pusher [px].
const Task& gymPusht();

/// Names of all tasks, the default first.
std::vector<std::string> taskNames();

/// Task of this name, or in the file of this path, or in a text of textOf(). Throws InvalidInput with the known ones
/// if there is none, or with entry, value and rule; BadDependency if a file cannot be read.
const Task& taskNamed(const std::string& name);

/// Text that taskNamed() reads as `task`, wherever a run carries it: the name of one that comes with the suite, else
/// its JSON.
std::string textOf(const Task& task);

/// Task as the JSON of its file (docs/tasks.md).
nlohmann::ordered_json describe(const Task& task);

/// `action` with each axis clipped as the task says.
Action clip(const Action& action, const Task& task = fullCircle());

/// Command of an action to the drive: a velocity [m/s] or a position [m], in the table frame.
Eigen::Vector2d commandOf(const Action& action, const Task& task);

/// [unit of an action per m/s] How much the action of actionFor() changes with the velocity.
double actionPerSpeed(const Task& task);

/// Action that lets a pusher at `position` [m] go on at `velocity` [m/s], in the table frame: that velocity, or the
/// position at which spring and damper of the drive are even. It is clipped.
Action actionFor(const Eigen::Vector2d& velocity, const Eigen::Vector2d& position, const Task& task);

/// Observation of `state` for a policy, in the task's own units and frame.
Observation observe(const WorldState& state, const Task& task = fullCircle());

/// Two bodies of the task that overlap, and how deep.
struct Overlap {
  const char* bodies = "";  ///< "pusher and tee", "pusher and walls", "tee and walls"
  double depth = 0.0;       ///< [m]; 0 or less: none overlap
};
/// The deepest overlap of a state.
Overlap deepestOverlap(const WorldState& state, const Task& task = fullCircle());

/// [m] Distance of a point from the walls' middle, along the axis where it is larger: a wall is at
/// Physics::wall_inner_face.
double reachOf(const Eigen::Vector2d& point, const Physics& physics);

/// Distance of the tee from its target pose.
struct PoseError {
  double position = 0.0;  ///< [m]
  double angle = 0.0;     ///< [rad] in [0, pi]
};
/// Distance of the tee from the target in position [m] and yaw [rad].
PoseError poseError(const WorldState& state, const Task& task = fullCircle());

/// State whose tee is at rest on the target, the pusher between the walls.
WorldState stateAtTarget(const Task& task);

/// [-] Share of the target that the tee covers.
double coverageOf(const WorldState& state, const Task& task);

/// How far a state is from solved, for people: "0.012 m, 0.05 rad off", or "covers 0.83" where coverage judges.
std::string distanceText(const WorldState& state, const Task& task);

/// Whether a state counts as solved.
bool isSolved(const WorldState& state, const Task& task = fullCircle());

/// Success: so many consecutive control steps solved as the task says. Once latched it stays.
class SuccessLatch {
 public:
  SuccessLatch() : SuccessLatch(fullCircle()) {}
  explicit SuccessLatch(const Task& task) : task_(&task) {}

  /// Takes the state after a control step. Returns true in the one step that latches.
  bool update(const WorldState& state);
  bool latched() const { return latched_; }

 private:
  const Task* task_;
  int steps_solved_ = 0;
  bool latched_ = false;
};

/// Reward of a control step that ends in `state`; `just_latched` as returned by SuccessLatch::update. By tolerances:
/// see kRewardPositionScale. By coverage: the share of the coverage that success needs, at most 1.
double reward(const WorldState& state, bool just_latched, const Task& task = fullCircle());

}  // namespace pusht
