// SPDX-License-Identifier: BSD-3-Clause
/// Audit of a policy: is it asked as it was trained? It is given recorded observations, and its answers are held
/// against the recorded actions. If they are far from them, a search names the fault of the interface that explains it.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "pusht_task/policy.hpp"
#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// Demonstration: an observation and an action for each control step.
struct Demonstration {
  std::vector<pusht::Observation> observations;  ///< [m, -]
  std::vector<pusht::Action> actions;            ///< [m/s]; as many
};

/// Signature of a policy, which its interface does not tell.
struct PolicySignature {
  int observations = 1;        ///< observations that an answer depends on, besides a state
  int actions = 1;             ///< actions of an answer
  bool has_state = false;      ///< a memory beyond the observations
  bool is_stochastic = false;  ///< answers with random numbers

  /// Whether an action follows from one observation alone.
  bool isPlain() const { return observations == 1 && actions == 1 && !has_state && !is_stochastic; }
};

/// What an audit says of a policy.
enum class PolicyVerdict {
  kNear,        ///< its actions are near the recorded ones, and no fault explains the rest
  kFault,       ///< a fault explains the error
  kUnexplained  ///< its actions are far from the recorded ones, and no fault of the list explains it
};

/// "near", "fault", "unexplained".
const char* nameOf(PolicyVerdict verdict);

/// Corrections under which a policy was asked once more, and its error then.
struct Explanation {
  std::vector<std::string> corrections;  ///< one or two, in words: "pusher and tee swapped"
  Estimate error;                        ///< [m/s]
  bool is_named = false;                 ///< whether it is the fault, or one of those that explain the error as well
};

/// Result of an audit of a policy. Errors are mean distances between its actions and the recorded ones [m/s], over the
/// episodes that the search did not see; of a policy that draws random numbers, energy scores (docs/audit.md).
struct PolicyAudit {
  PolicyVerdict verdict = PolicyVerdict::kNear;
  PolicySignature signature;
  std::size_t episodes = 0;  ///< of the demonstrations
  std::size_t steps = 0;
  std::size_t units = 0;                  ///< episodes, or parts of them, that the figures are means of
  bool are_episodes = true;               ///< whether units are whole episodes
  int draws = 1;                          ///< answers to each question; above 1 for random numbers
  std::size_t tried = 0;                  ///< faults and pairs of faults that the search looked at
  Estimate error;                         ///< of the policy as it is
  Estimate constant;                      ///< of the best constant action; with random numbers of any recorded action
  std::vector<Explanation> explanations;  ///< the best ones; those that are named first

  /// The fault that explains the error, in words; empty if there is none.
  std::string fault() const;
};

/// Asks `policy`. The same demonstrations give the same bytes. Throws InvalidInput if there are too few demonstrations,
/// BadDependency if an answer to recorded observations is not finite, and what the policy throws.
PolicyAudit auditPolicy(pusht::Policy& policy, const PolicySignature& signature,
                        const std::vector<Demonstration>& demonstrations);

/// One screen of text, the verdict first. `name` is the policy's, `demonstrations` their file's.
std::string textOf(const PolicyAudit& audit, const std::string& name, const std::string& demonstrations);

/// Audit as JSON.
nlohmann::ordered_json toJson(const PolicyAudit& audit);

}  // namespace sim2sim
