// SPDX-License-Identifier: BSD-3-Clause
/// Planning expert: it tries out in a world what it does next.
#pragma once

#include <memory>

#include "pusht_task/policy.hpp"
#include "pusht_task/simulator.hpp"

namespace pusht {

class StrokePlanner;

/// Pushes the tee to the target in straight strokes, each planned in a world of its own when the one before has ended,
/// and made as planned. It reaches gym-pusht's coverage in gym-pusht's world, and acts in any: what a stroke did
/// otherwise than planned, the next one mends. Its memory is what is left of a stroke; its random numbers are those of
/// the search.
class PlanningExpert : public Policy {
 public:
  /// Plans for the task of `world`, in it.
  explicit PlanningExpert(std::unique_ptr<Simulator> world);
  ~PlanningExpert() override;

  std::unique_ptr<Memory> begin(const Beginning& beginning) const override;

  /// Throws InvalidInput for an observation that is no plausible state; SimulationFault if the world fails.
  void act(Span<const Query> queries, Span<Action> actions) override;

 private:
  struct Stroke;

  Action answerTo(const Observation& observation, Stroke& stroke);
  void planNext(const WorldState& state, Stroke& stroke);

  std::unique_ptr<StrokePlanner> planner_;
};

}  // namespace pusht
