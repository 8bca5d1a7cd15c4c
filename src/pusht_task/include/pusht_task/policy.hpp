// SPDX-License-Identifier: BSD-3-Clause
/// Interface of a policy.
#pragma once

#include <memory>

#include "pusht_task/types.hpp"

namespace pusht {

/// Maps observations to actions, many rollouts at a time. Rows are independent: a row's action never
/// depends on its neighbours or on their number.
class Policy {
 public:
  /// What a policy remembers of one rollout from step to step. It belongs to the rollout, so that the
  /// policy itself can serve any number of them.
  struct Memory {
    Memory() = default;
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;
    virtual ~Memory() = default;
  };

  /// One rollout that needs an action.
  struct Query {
    Observation observation;
    Memory* memory;  ///< from begin() of the same policy
  };

  Policy() = default;
  Policy(const Policy&) = delete;
  Policy& operator=(const Policy&) = delete;
  virtual ~Policy() = default;

  /// The memory at the start of a rollout; null for a policy that has none.
  virtual std::unique_ptr<Memory> begin() const { return nullptr; }

  /// Fills actions[i] for queries[i]; both have the same size. Not to be called from two threads at once.
  virtual void act(Span<const Query> queries, Span<Action> actions) = 0;
};

}  // namespace pusht
