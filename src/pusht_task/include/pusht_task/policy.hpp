// SPDX-License-Identifier: BSD-3-Clause
/// Interface of a policy.
#pragma once

#include <cstdint>
#include <memory>

#include "pusht_task/types.hpp"

namespace pusht {

namespace gym_pusht {
struct State;
}

/// Role of the simulator that a closed loop runs in.
enum class Role { kReference, kEngine };

/// What a policy is told of a rollout that begins.
struct Beginning {
  std::uint64_t seed = 0;  ///< of the rollout's random numbers; each use has a stream of its own (spawn.hpp)
  int execute = 0;         ///< actions of a chunk that are executed before the next is computed; 0: as the policy says
  Role role = Role::kReference;
};

/// Map from observations to actions, for many rollouts at a time. Rows are independent: an action does not depend on
/// the other rows or on their number.
class Policy {
 public:
  /// Memory of a policy between the steps of one rollout. It belongs to the rollout, so one policy object serves any
  /// number of rollouts.
  struct Memory {
    Memory() = default;
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;
    virtual ~Memory() = default;
  };

  /// Rollout that needs an action.
  struct Query {
    Observation observation;
    Memory* memory;                     ///< from begin() of the same policy
    const WorldState* state = nullptr;  ///< state behind the observation; null if the query came over a node
    /// State in gym-pusht's own bits, as Simulator::stateInPixels(); null also if the query came over a node, or from a
    /// sensor with noise.
    const gym_pusht::State* state_in_pixels = nullptr;
  };

  Policy() = default;
  Policy(const Policy&) = delete;
  Policy& operator=(const Policy&) = delete;
  virtual ~Policy() = default;

  /// Memory at the beginning of a rollout; null for a policy without memory. All that is random in the rollout comes
  /// from the seed of `beginning`. Throws InvalidInput if more actions are to be executed than an answer has.
  virtual std::unique_ptr<Memory> begin(const Beginning& beginning) const;

  /// Fills actions[i] for queries[i], one action for this control step; the rest of a chunk waits in the memory. Both
  /// have the same size. Not to be called from two threads at once.
  virtual void act(Span<const Query> queries, Span<Action> actions) = 0;

 protected:
  /// Throws InvalidInput if more actions are to be executed than the `answered` ones of an answer.
  static void requireExecutable(const Beginning& beginning, int answered);
};

}  // namespace pusht
