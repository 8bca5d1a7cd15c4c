// SPDX-License-Identifier: BSD-3-Clause
/// Interface of a policy.
#pragma once

#include <memory>

#include "pusht_task/types.hpp"

namespace pusht {

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
    Memory* memory;  ///< from begin() of the same policy
  };

  Policy() = default;
  Policy(const Policy&) = delete;
  Policy& operator=(const Policy&) = delete;
  virtual ~Policy() = default;

  /// Memory at the beginning of a rollout; null for a policy without memory.
  virtual std::unique_ptr<Memory> begin() const { return nullptr; }

  /// Fills actions[i] for queries[i]; both have the same size. Not to be called from two threads at once.
  virtual void act(Span<const Query> queries, Span<Action> actions) = 0;
};

}  // namespace pusht
