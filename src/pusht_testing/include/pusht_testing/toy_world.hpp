// SPDX-License-Identifier: BSD-3-Clause
/// A simulator without physics, to test what all have in common.
#pragma once

#include <cmath>
#include <memory>

#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/simulator_kind.hpp"

namespace pusht {

/// The pusher goes where it is told and shoves the tee ahead of it. A step with a
/// pusher faster than 10 000 m/s fails.
class ToyWorld : public Simulator {
 public:
  enum class Precision { kSingle, kDouble };

  explicit ToyWorld(Precision precision = Precision::kDouble, double start_tolerance = 1e-12)
      : Simulator("", start_tolerance), precision_(precision) {}

 private:
  void doReset(const WorldState& state) override {
    state_ = state;
    round();
  }

  void doStep(const Action& action) override {
    constexpr double kReach = 0.08;              // [m]
    constexpr double kGreatestSpeed = 10'000.0;  // [m/s]
    if (state_.pusher_velocity.norm() > kGreatestSpeed) {
      throw SimulationFault("step: the toy is broken");
    }
    state_.pusher_velocity = {action[0], action[1]};
    state_.pusher_position += kControlStep * state_.pusher_velocity;
    const Eigen::Vector2d way = state_.tee_position - state_.pusher_position;
    if (way.norm() < kReach) {
      state_.tee_position = state_.pusher_position + kReach * way.normalized();
    }
    round();
  }

  WorldState doState() const override { return state_; }

  void round() {
    if (precision_ == Precision::kDouble) {
      return;
    }
    for (Eigen::Vector2d* vector :
         {&state_.pusher_position, &state_.pusher_velocity, &state_.tee_position, &state_.tee_velocity}) {
      for (double& number : *vector) {
        number = static_cast<float>(number);
      }
    }
    state_.tee_yaw_rate = static_cast<float>(state_.tee_yaw_rate);
    // The float that is nearest to pi is above it.
    const auto yaw = static_cast<float>(state_.tee_yaw);
    state_.tee_yaw = std::abs(yaw) < kPi ? yaw : std::nextafter(yaw, 0.0F);
  }

  Precision precision_;
  WorldState state_;
};

/// Kind of that world; `start_tolerance` is what it says of itself, right or wrong.
inline SimulatorKind toyKind(ToyWorld::Precision precision = ToyWorld::Precision::kDouble,
                             double start_tolerance = 1e-12) {
  SimulatorKind kind;
  kind.name = "toy";
  kind.title = "toy";
  kind.version = "1";
  kind.start_tolerance = start_tolerance;
  kind.loader = [=](const ParameterSet& parameters) {
    return modelOfWorlds(parameters, [=] { return std::make_unique<ToyWorld>(precision, start_tolerance); });
  };
  return kind;
}

}  // namespace pusht
