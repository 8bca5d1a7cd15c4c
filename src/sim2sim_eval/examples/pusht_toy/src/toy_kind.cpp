// SPDX-License-Identifier: BSD-3-Clause
#include "toy_kind.hpp"

#include <memory>

#include "pusht_task/simulator.hpp"
#include "pusht_task/simulator_plugin.hpp"

namespace {

constexpr double kStartTolerance = 1e-12;  // [m, rad, m/s, rad/s] it keeps what it is told

class ToyWorld : public pusht::Simulator {
 public:
  explicit ToyWorld(double reach) : Simulator("", kStartTolerance), reach_(reach) {}

 private:
  void doReset(const pusht::WorldState& state) override { state_ = state; }

  void doStep(const pusht::Action& action) override {
    state_.pusher_velocity = {action[0], action[1]};
    state_.pusher_position += pusht::kControlStep * state_.pusher_velocity;
    const Eigen::Vector2d way = state_.tee_position - state_.pusher_position;
    if (way.norm() < reach_) {
      state_.tee_position = state_.pusher_position + reach_ * way.normalized();
    }
  }

  pusht::WorldState doState() const override { return state_; }

  double reach_;  // [m]
  pusht::WorldState state_;
};

pusht::SimulatorModel load(const pusht::ParameterSet& parameters) {
  return pusht::modelOfWorlds(parameters,
                              [reach = parameters.get<double>("reach")] { return std::make_unique<ToyWorld>(reach); });
}

}  // namespace

const pusht::SimulatorKind& toyKind() {
  static const pusht::SimulatorKind kind = {
      "toy", "toy", "1", {{"reach", "m", "from pusher to tee", 0.08, 0.0, 0.2}}, {}, kStartTolerance, load};
  return kind;
}

PUSHT_EXPORT_SIMULATOR_KIND(toy, toyKind);
