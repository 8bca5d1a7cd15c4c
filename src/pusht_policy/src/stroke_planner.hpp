// SPDX-License-Identifier: BSD-3-Clause
/// Planner of strokes: straight pushes of the tee, tried out in a world before they are made.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "pusht_task/simulator.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/types.hpp"
#include "tee_outline.hpp"

namespace pusht {

/// Action that draws a pusher at `position` to `reference`, both in the table frame [m].
Action actionToward(const Eigen::Vector2d& reference, const Eigen::Vector2d& position, const Task& task);

/// What to do next: the way to where a stroke begins, and the stroke.
struct Plan {
  std::vector<Eigen::Vector2d> references;  ///< [m] for each control step where the pusher is drawn to
  WorldState end;                           ///< state in which it is expected to leave the world
};

/// Plans one stroke at a time. A stroke is given by three numbers: where on the tee's outline, in which direction, how
/// far. What it does depends on nothing else, as long as a tee that is not pushed stands still.
///
/// 1. Probes: strokes on a grid around the tee, from rest at their first point. Each probe tries all lengths at once.
/// 2. Trials: the best few, each with the way to its first point, which is the fastest that does not bump into the tee.
/// 3. Refinement: a random search around the best trial.
/// 4. Lookahead: where no stroke improves the state much, as in a corner of the table, the stroke after which the best
///    probe is best.
///
/// A state costs the logarithm of its error plus a price for each control step, so that what counts is progress for
/// its time, both far from the target and near it.
class StrokePlanner {
 public:
  /// Plans for the task of `world`, in it.
  explicit StrokePlanner(std::unique_ptr<Simulator> world);

  const Task& task() const { return world_->task(); }

  /// Best plan found from `state`; none if the pusher reaches no point from which it could push. The same state and
  /// random numbers give the same plan. Throws as Simulator::reset() and step().
  std::optional<Plan> plan(const WorldState& state, NumpyGenerator& random);

 private:
  struct Stroke {
    double share;         // of the tee's outline, where it is aimed at
    double angle;         // [rad] from the way into the tee there
    double travel = 0.0;  // [m] of the pusher
  };

  /// Straight way of the pusher's center in the table frame.
  struct Line {
    Eigen::Vector2d begin;      // [m]
    Eigen::Vector2d direction;  // [-] unit vector

    Eigen::Vector2d at(double travel) const { return begin + travel * direction; }
  };

  struct Probe {
    Stroke stroke;
    double cost;
  };

  struct Trial {
    Stroke stroke;
    Plan plan;
    double cost;
  };

  std::vector<Probe> probesAround(const WorldState& state, int points, Span<const double> angles, double shift);
  std::optional<Probe> probe(const WorldState& state, const Stroke& aim);
  std::optional<Trial> bestStroke(const WorldState& state, NumpyGenerator& random);
  std::optional<Trial> bestOfTwo(const WorldState& state, NumpyGenerator& random);
  void refine(Trial& best, const WorldState& state, NumpyGenerator& random);
  std::optional<Trial> trial(const WorldState& state, const Stroke& stroke);
  std::optional<Line> lineOf(const WorldState& state, const Stroke& stroke) const;
  std::vector<Eigen::Vector2d> wayTo(const Eigen::Vector2d& point, const WorldState& state) const;

  void approach(Plan& plan, const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& goal);
  void push(Plan& plan, const Line& line, double travel);
  void follow(Plan& plan, const Eigen::Vector2d& reference);
  WorldState stepToward(const Eigen::Vector2d& reference);
  bool isOnTable(const Eigen::Vector2d& point) const;
  double errorOf(const WorldState& state) const;
  double costOf(const WorldState& state, int steps) const;

  std::unique_ptr<Simulator> world_;
  TeeOutline outline_;
};

}  // namespace pusht
