// SPDX-License-Identifier: BSD-3-Clause
#include "policy_interview.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

namespace sim2sim {
namespace {

using pusht::Action;
using pusht::Observation;
using pusht::Policy;

constexpr int kDrawShift = 32;  // seeds of a draw's rollouts

/// Observations of a demonstration for a whole number of answers of `actions` actions: the last one is repeated.
std::vector<Observation> filledUp(const std::vector<Observation>& observations, std::size_t actions) {
  std::vector<Observation> filled = observations;
  filled.resize((observations.size() + actions - 1) / actions * actions, observations.back());
  return filled;
}

double distanceBetween(const Action& a, const Action& b) {
  const double x = static_cast<double>(a[0]) - b[0];
  const double y = static_cast<double>(a[1]) - b[1];
  return std::sqrt(x * x + y * y);
}

/// Energy score of the actions that several draws give at one step: their mean distance from the recorded one, less
/// half their mean distance from each other.
double energyScore(const std::vector<std::vector<Action>>& draws, std::size_t given, const Action& recorded) {
  const auto count = static_cast<double>(draws.size());
  double from_recorded = 0.0;
  double from_each_other = 0.0;
  for (std::size_t one = 0; one < draws.size(); ++one) {
    from_recorded += distanceBetween(draws[one][given], recorded);
    for (std::size_t other = 0; other < one; ++other) {
      from_each_other += distanceBetween(draws[one][given], draws[other][given]);
    }
  }
  return from_recorded / count - (draws.size() > 1 ? from_each_other / (count * (count - 1.0)) : 0.0);
}

/// Mean score in a unit of the actions of several draws, read `later` control steps later.
double errorIn(const Unit& unit, const std::vector<std::vector<Action>>& draws, const std::vector<Action>& recorded,
               int later) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t step = unit.begin; step < unit.end; ++step) {
    const auto given = static_cast<std::ptrdiff_t>(step) - later;
    if (given >= 0 && given < static_cast<std::ptrdiff_t>(recorded.size())) {
      sum += energyScore(draws, static_cast<std::size_t>(given), recorded[step]);
      ++count;
    }
  }
  return count > 0 && std::isfinite(sum) ? sum / count : std::numeric_limits<double>::infinity();
}

/// Answers to parts of sequences, one after the other, as answers to the sequences.
Answers joinedLike(const std::vector<std::vector<Observation>>& sequences, const Answers& parts) {
  Answers answers;
  auto next = parts.begin();
  for (const std::vector<Observation>& sequence : sequences) {
    answers.emplace_back();
    while (answers.back().size() < sequence.size()) {
      answers.back().insert(answers.back().end(), next->begin(), next->end());
      ++next;
    }
  }
  return answers;
}

}  // namespace

Sample sampleOf(const PolicySignature& signature, const std::vector<Demonstration>& demonstrations,
                const std::vector<Unit>& units) {
  Sample sample;
  for (const Unit& unit : units) {
    const Demonstration& whole = demonstrations[unit.demonstration];
    const std::size_t back = signature.has_state ? unit.begin : static_cast<std::size_t>(signature.observations - 1);
    const std::size_t first = unit.begin - std::min(back, unit.begin);
    const auto begin = static_cast<std::ptrdiff_t>(first);
    const auto end = static_cast<std::ptrdiff_t>(unit.end);
    sample.units.push_back({sample.demonstrations.size(), unit.begin - first, unit.end - first});
    sample.demonstrations.push_back({{whole.observations.begin() + begin, whole.observations.begin() + end},
                                     {whole.actions.begin() + begin, whole.actions.begin() + end}});
  }
  return sample;
}

PolicyInterview::PolicyInterview(Policy& policy, const PolicySignature& signature)
    : policy_(policy), signature_(signature) {}

Draws PolicyInterview::answersTo(const Sample& sample, const Corrections& corrections, int draws) {
  Sequences sequences;
  for (const Demonstration& demonstration : sample.demonstrations) {
    sequences.push_back(filledUp(demonstration.observations, static_cast<std::size_t>(signature_.actions)));
  }
  const Correction* history = nullptr;
  for (const Correction* correction : corrections) {
    for (std::vector<Observation>& sequence : sequences) {
      if (correction->observation) {
        std::transform(sequence.begin(), sequence.end(), sequence.begin(), correction->observation);
      }
    }
    history = correction->history ? correction : history;
  }
  Draws all;
  for (int draw = 0; draw < (signature_.is_stochastic ? draws : 1); ++draw) {
    // Each rollout of each draw has random numbers of its own: rollouts with the same ones would err together.
    const std::uint64_t seed = static_cast<std::uint64_t>(draw) << kDrawShift;
    all.push_back(history != nullptr     ? callByCall(sequences, *history, seed)
                  : signature_.isPlain() ? stepByStep(sequences, seed)
                                         : inTurn(sequences, seed, 0));
  }
  return all;
}

/// Actions of rollouts that see these sequences, step by step, without the first `skipped` of each.
Answers PolicyInterview::inTurn(const Sequences& sequences, std::uint64_t seed, std::size_t skipped) {
  std::vector<std::unique_ptr<Policy::Memory>> memories;
  std::size_t longest = 0;
  for (const std::vector<Observation>& sequence : sequences) {
    memories.push_back(policy_.begin({seed + memories.size(), signature_.actions}));
    longest = std::max(longest, sequence.size());
  }
  Answers answers(sequences.size());
  std::vector<Policy::Query> queries;
  std::vector<std::size_t> asking;
  std::vector<Action> actions;
  for (std::size_t step = 0; step < longest; ++step) {
    queries.clear();
    asking.clear();
    for (std::size_t i = 0; i < sequences.size(); ++i) {
      if (step < sequences[i].size()) {
        queries.push_back({sequences[i][step], memories[i].get()});
        asking.push_back(i);
      }
    }
    actions.resize(queries.size());
    policy_.act(queries, actions);
    for (std::size_t row = 0; row < asking.size() && step >= skipped; ++row) {
      answers[asking[row]].push_back(actions[row]);
    }
  }
  return answers;
}

/// Answers of a policy without any memory: all steps at once, each as a rollout of its own.
Answers PolicyInterview::stepByStep(const Sequences& sequences, std::uint64_t seed) {
  Sequences rollouts;
  for (const std::vector<Observation>& sequence : sequences) {
    for (const Observation& observation : sequence) {
      rollouts.push_back({observation});
    }
  }
  return joinedLike(sequences, inTurn(rollouts, seed, 0));
}

/// Answers where the history of each call is another one than its past. Each call is a rollout of its own, in which the
/// policy is shown the corrected history, and asked when it has seen all of it.
Answers PolicyInterview::callByCall(const Sequences& sequences, const Correction& history, std::uint64_t seed) {
  const auto past = static_cast<std::size_t>(signature_.observations);
  const auto actions = static_cast<std::size_t>(signature_.actions);
  // A rollout is asked at its first step and every `actions` steps: at the first such step that has seen enough.
  const std::size_t call = (past - 1 + actions - 1) / actions * actions;
  Sequences rollouts;
  for (const std::vector<Observation>& sequence : sequences) {
    for (std::size_t step = 0; step < sequence.size(); step += actions) {
      std::vector<Observation> seen;
      for (std::size_t back = past; back-- > 0;) {
        seen.push_back(sequence[step >= back ? step - back : 0]);
      }
      seen = history.history(seen);
      std::vector<Observation> rollout(call + 1 - past, seen.front());
      rollout.insert(rollout.end(), seen.begin(), seen.end());
      rollout.resize(call + actions, seen.back());
      rollouts.push_back(std::move(rollout));
    }
  }
  return joinedLike(sequences, inTurn(rollouts, seed, call));
}

std::vector<Action> PolicyInterview::read(std::vector<Action> actions, const Demonstration& demonstration,
                                          const Corrections& corrections) const {
  const auto chunk = signature_.actions;
  for (const Correction* correction : corrections) {
    if (correction->chunk) {
      for (auto begin = actions.begin(); begin != actions.end(); begin += chunk) {
        const std::vector<Action> changed = correction->chunk({begin, begin + chunk});
        std::copy(changed.begin(), changed.end(), begin);
      }
    }
    if (correction->action) {
      const std::size_t steps = demonstration.observations.size();
      std::transform(actions.begin(), actions.begin() + static_cast<std::ptrdiff_t>(steps),
                     demonstration.observations.begin(), actions.begin(), correction->action);
    }
  }
  return actions;
}

std::vector<double> PolicyInterview::errorsOf(const Sample& sample, const Draws& draws,
                                              const Corrections& corrections) const {
  int later = 0;
  for (const Correction* correction : corrections) {
    later += correction->later;
  }
  std::vector<std::vector<std::vector<Action>>> read(sample.demonstrations.size());  // of each, the draws
  for (const Answers& answers : draws) {
    for (std::size_t i = 0; i < answers.size(); ++i) {
      read[i].push_back(this->read(answers[i], sample.demonstrations[i], corrections));
    }
  }
  std::vector<double> errors;
  for (const Unit& unit : sample.units) {
    errors.push_back(errorIn(unit, read[unit.demonstration], sample.demonstrations[unit.demonstration].actions, later));
  }
  return errors;
}

}  // namespace sim2sim
