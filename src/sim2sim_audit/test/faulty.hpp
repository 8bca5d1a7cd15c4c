// SPDX-License-Identifier: BSD-3-Clause
/// Worlds with an error at their interface, over any simulator.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/spawn.hpp"

namespace sim2sim::testing {

/// Error at the interface of a world: what it makes of starts, states and commands.
struct InterfaceFault {
  using OfState = std::function<pusht::WorldState(const pusht::WorldState&)>;
  using OfAction = std::function<pusht::Action(const pusht::Action&)>;

  OfState start = [](const pusht::WorldState& state) { return state; };  ///< requested start to that of the inner world
  OfState report = [](const pusht::WorldState& state) { return state; };  ///< state of the inner world to the reported
  OfAction command = [](const pusht::Action& action) { return action; };
  int delay = 0;       ///< [control steps] by which commands are late
  bool stale = false;  ///< reports the state before the last step
  double leak = 0.0;   ///< [-] share of the last episode's last command that is added to the first one of the next
  double noise = 0.0;  ///< [m] greatest error of each reported position, after steps
};

/// A world with such an error.
class Faulty : public pusht::Simulator {
 public:
  Faulty(std::unique_ptr<pusht::Simulator> inner, InterfaceFault fault)
      : Simulator("faulty", inner->startTolerance()), inner_(std::move(inner)), fault_(std::move(fault)) {}

 private:
  void doReset(const pusht::WorldState& state) override {
    inner_->reset(fault_.start(state));
    left_over_ = last_;
    waiting_.assign(static_cast<std::size_t>(fault_.delay), pusht::Action{0.0F, 0.0F});
    reported_ = fault_.report(inner_->state());
  }

  void doStep(const pusht::Action& action) override {
    const pusht::WorldState before = inner_->state();
    waiting_.push_back(fault_.command(action));
    pusht::Action command = waiting_.front();
    waiting_.pop_front();
    for (std::size_t axis = 0; axis < 2; ++axis) {
      command[axis] += static_cast<float>(fault_.leak) * left_over_[axis];
    }
    left_over_ = {0.0F, 0.0F};
    last_ = action;
    inner_->step(command);
    reported_ = fault_.report(fault_.stale ? before : inner_->state());
    if (fault_.noise > 0.0) {
      for (Eigen::Vector2d* position : {&reported_.pusher_position, &reported_.tee_position}) {
        for (double& number : *position) {
          number += generator_.uniform(-fault_.noise, fault_.noise);
        }
      }
    }
  }

  pusht::WorldState doState() const override { return reported_; }

  std::unique_ptr<pusht::Simulator> inner_;
  InterfaceFault fault_;
  std::deque<pusht::Action> waiting_;
  pusht::Action last_ = {0.0F, 0.0F};
  pusht::Action left_over_ = {0.0F, 0.0F};
  pusht::WorldState reported_;
  pusht::NumpyGenerator generator_{7, "noise of a faulty world"};
};

/// `vector` turned by the yaw of `state`, from body to table axes.
inline Eigen::Vector2d toTable(const pusht::WorldState& state, const Eigen::Vector2d& vector) {
  return Eigen::Rotation2Dd(state.tee_yaw) * vector;
}

/// Velocity of the point at `arm` (table axes) of the tee less that of its origin.
inline Eigen::Vector2d turning(const pusht::WorldState& state, const Eigen::Vector2d& arm) {
  return state.tee_yaw_rate * Eigen::Vector2d(-arm.y(), arm.x());
}

/// State in which the tee's place and velocity are those of the point at `point` [m] (body axes).
inline pusht::WorldState movedTo(pusht::WorldState state, const Eigen::Vector2d& point) {
  const Eigen::Vector2d arm = toTable(state, point);
  state.tee_position += arm;
  state.tee_velocity += turning(state, arm);
  return state;
}

}  // namespace sim2sim::testing
