// SPDX-License-Identifier: BSD-3-Clause
/// Interview of a policy: it is asked with recorded observations, under corrections, and its answers are held against
/// the recorded actions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "policy_correction.hpp"
#include "pusht_task/policy.hpp"

namespace sim2sim {

/// Corrections that act together, in the order of their groups.
using Corrections = std::vector<const Correction*>;

/// Part of a demonstration whose mean error is one sample: control steps [begin, end).
struct Unit {
  std::size_t demonstration;
  std::size_t begin;
  std::size_t end;

  std::size_t steps() const { return end - begin; }
};

/// Demonstrations, and the parts of them that count.
struct Sample {
  std::vector<Demonstration> demonstrations{};
  std::vector<Unit> units{};
};

/// Sample of these units. Demonstrations are cut off behind them, and as far before them as a policy of this signature
/// does not look back.
Sample sampleOf(const PolicySignature& signature, const std::vector<Demonstration>& demonstrations,
                const std::vector<Unit>& units);

/// Actions in answer to each demonstration of a sample: those of a whole number of answers.
using Answers = std::vector<std::vector<pusht::Action>>;

/// Answers of a policy that draws random numbers, asked several times; of another one, its answers alone.
using Draws = std::vector<Answers>;

/// A policy that is asked.
class PolicyInterview {
 public:
  /// `policy` must outlive it.
  PolicyInterview(pusht::Policy& policy, const PolicySignature& signature);

  const PolicySignature& signature() const { return signature_; }

  /// The policy's actions, where it is asked under those of `corrections` that are of questions. A policy that draws
  /// random numbers is asked `draws` times. All actions of an answer are executed before it is asked again.
  Draws answersTo(const Sample& sample, const Corrections& corrections, int draws);

  /// Mean score [m/s] of the actions against the recorded ones in each unit, where answers are read under those of
  /// `corrections` that are of answers. It is the distance; of several draws the energy score (Gneiting and Raftery,
  /// "Strictly Proper Scoring Rules", 2007, eq. 21 with beta 1), estimated without bias. It is the least for the
  /// distribution that the recorded actions come from, so actions do not gain by being smaller.
  /// Infinite if a number is not finite.
  std::vector<double> errorsOf(const Sample& sample, const Draws& draws, const Corrections& corrections) const;

 private:
  using Sequences = std::vector<std::vector<pusht::Observation>>;

  Answers inTurn(const Sequences& sequences, std::uint64_t seed, std::size_t skipped);
  Answers stepByStep(const Sequences& sequences, std::uint64_t seed);
  Answers callByCall(const Sequences& sequences, const Correction& history, std::uint64_t seed);
  std::vector<pusht::Action> read(std::vector<pusht::Action> actions, const Demonstration& demonstration,
                                  const Corrections& corrections) const;

  pusht::Policy& policy_;
  PolicySignature signature_;
};

}  // namespace sim2sim
