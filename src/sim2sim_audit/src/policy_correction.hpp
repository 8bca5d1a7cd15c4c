// SPDX-License-Identifier: BSD-3-Clause
/// Corrections: what is done to observations and answers to undo a fault of a policy's interface.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pusht_task/types.hpp"
#include "sim2sim_audit/policy_audit.hpp"

namespace sim2sim {

/// Undoes one fault. A policy that swaps pusher and tee is right where it is given them swapped.
struct Correction {
  /// What a fault is about. Two faults at once are of different groups. The order is that in which corrections are
  /// applied: the last thing that happens to an observation before the network sees it is undone first.
  enum class Group {
    kNormalization,
    kOrder,
    kWithinPairs,
    kFrame,
    kOrigin,
    kUnits,
    kAngle,
    kAxes,
    kHistory,
    kChunk,
    kTime,
    kMeaning,
    kActionAxes,
    kActionScale,
  };
  using Observations = std::vector<pusht::Observation>;
  using Actions = std::vector<pusht::Action>;

  Group group;
  std::string words;
  bool is_common = true;  ///< whether pairs of it with every other correction are tried

  // One of these five is there.
  std::function<pusht::Observation(const pusht::Observation&)> observation{};
  std::function<Observations(const Observations&)> history{};  ///< of the observations of a call, the oldest first
  std::function<pusht::Action(const pusht::Action&, const pusht::Observation&)> action{};  ///< of an answer's action
  std::function<Actions(const Actions&)> chunk{};                                          ///< of an answer's actions
  int later = 0;  ///< control steps by which the answer for a step is given later
  std::function<std::vector<Correction>()> neighbors{};  ///< finer ones around one with numbers, itself among them

  /// Whether it changes what the policy is asked, not only how its answer is read.
  bool isOfQuestion() const { return observation || history; }
};

/// Corrections of observations that are worth a try with a policy of this signature, by group. Normalization takes its
/// numbers from the demonstrations.
std::vector<Correction> questionCorrections(const PolicySignature& signature,
                                            const std::vector<Demonstration>& demonstrations);

/// Corrections of answers.
std::vector<Correction> answerCorrections(const PolicySignature& signature,
                                          const std::vector<Demonstration>& demonstrations);

}  // namespace sim2sim
