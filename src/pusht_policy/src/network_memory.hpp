// SPDX-License-Identifier: BSD-3-Clause
/// Memory that a network has of a rollout.
#pragma once

#include <optional>
#include <vector>

#include "pusht_policy/policy_description.hpp"
#include "pusht_task/policy.hpp"
#include "pusht_task/spawn.hpp"

namespace pusht {

/// Noise of a rollout, drawn by the suite: a stream of its own for each seed.
class PolicyNoise {
 public:
  PolicyNoise(std::uint64_t seed, PolicyDescription::Distribution distribution);

  /// Fills `noise` with the next numbers, float32.
  void draw(Span<float> noise);

 private:
  NumpyGenerator generator_;
  PolicyDescription::Distribution distribution_;
};

/// Memory of a rollout: its latest observations, its last answer and how much of it was executed, the network's state
/// and its noise. At each control step: see(); if it isSpent(), draw() and fill answer(); then next().
class NetworkMemory final : public Policy::Memory {
 public:
  /// `beginning.execute` must fit the description; 0 is the description's own.
  NetworkMemory(const PolicyDescription& description, const Beginning& beginning);

  /// Takes the observation of this control step. The first one is repeated, as if there had been a past.
  void see(const Observation& observation);

  /// Whether the actions to be executed have run out, so that the network must be asked.
  bool isSpent() const { return next_ == execute_; }

  Span<const float> history() const {
    return history_;
  }  ///< [observations][numbers of the interface], the oldest first
  Span<float> state() { return state_; }

  /// Noise of a call, for a network that takes noise.
  void draw(Span<float> noise);

  /// Place of a new answer, [actions][2].
  Span<float> answer();

  /// Action of this control step.
  Action next();

 private:
  PolicyInterface interface_;
  std::vector<float> history_;
  bool begun_ = false;
  std::vector<float> state_;
  std::optional<PolicyNoise> noise_;
  std::vector<float> answer_;
  int execute_;
  int next_;
};

}  // namespace pusht
