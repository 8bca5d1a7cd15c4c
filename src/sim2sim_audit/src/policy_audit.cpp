// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_audit/policy_audit.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "policy_interview.hpp"
#include "policy_search.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/spawn.hpp"
#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

using pusht::Action;

// A sample.
constexpr std::size_t kFewestUnits = 30;
constexpr std::size_t kPartSteps = 20;        // of a part, where there are fewer episodes than kFewestUnits
constexpr std::size_t kSearchedUnits = 8;     // at least, for the search
constexpr std::size_t kSearchedSteps = 400;   // for the search, if that leaves kFewestPairs units
constexpr std::size_t kMeasuredSteps = 1500;  // enough for the decision
constexpr int kMeasuredDraws = 16;            // of a policy's random numbers

// The rule (docs/audit.md). Bounds are those of intervals.
constexpr double kKept = 0.92;       // a fault leaves at most this share of the error
constexpr double kExplained = 0.85;  // and at most this share of the error of a constant action
constexpr double kFar = 0.85;        // a policy is far beyond this share of the error of a constant action
constexpr double kAlike = 1.1;       // two faults explain the error equally well within this factor

/// Units: episodes, or parts of them where episodes are few.
std::vector<Unit> unitsIn(const std::vector<Demonstration>& demonstrations) {
  const bool are_episodes = demonstrations.size() >= kFewestUnits;
  std::vector<Unit> units;
  for (std::size_t i = 0; i < demonstrations.size(); ++i) {
    const std::size_t steps = demonstrations[i].actions.size();
    const std::size_t parts = are_episodes ? 1 : std::max<std::size_t>(1, steps / kPartSteps);
    for (std::size_t part = 0; part < parts; ++part) {
      units.push_back({i, part * steps / parts, (part + 1) * steps / parts});
    }
  }
  if (units.size() < kFewestUnits) {
    throw pusht::InvalidInput(std::to_string(demonstrations.size()) + " episodes with " + std::to_string(units.size()) +
                              " parts of at least " + std::to_string(kPartSteps) + " control steps: must be at least " +
                              std::to_string(kFewestUnits) + " episodes or parts");
  }
  return units;
}

using UnitIterator = std::vector<Unit>::const_iterator;

/// End of the units from `begin` on, at most up to `end`, that are at least so many and have so many steps.
UnitIterator enough(UnitIterator begin, UnitIterator end, std::size_t units, std::size_t steps) {
  std::size_t have = 0;
  auto last = begin;
  while (last != end && (static_cast<std::size_t>(last - begin) < units || have < steps)) {
    have += last->steps();
    ++last;
  }
  return last;
}

/// Component-wise median of the recorded actions.
Action bestConstant(const Sample& sample) {
  Action constant{};
  for (std::size_t axis = 0; axis < constant.size(); ++axis) {
    std::vector<double> values;
    for (const Demonstration& demonstration : sample.demonstrations) {
      std::transform(demonstration.actions.begin(), demonstration.actions.end(), std::back_inserter(values),
                     [axis](const Action& action) { return action[axis]; });
    }
    std::sort(values.begin(), values.end());
    constant[axis] = static_cast<float>(quantileOf(values, 0.5));
  }
  return constant;
}

/// Answers of a policy that does not look: a constant action, or, where policies draw random numbers, as it is scored
/// then, any of the recorded actions.
class Blind {
 public:
  Blind(const Sample& known, bool is_stochastic) : constant_(bestConstant(known)), is_stochastic_(is_stochastic) {
    for (const Demonstration& demonstration : known.demonstrations) {
      recorded_.insert(recorded_.end(), demonstration.actions.begin(), demonstration.actions.end());
    }
  }

  /// Errors in each unit.
  std::vector<double> errorsIn(const PolicyInterview& interview, const Sample& sample) const {
    pusht::NumpyGenerator random(0, "blind actions");
    Draws draws(is_stochastic_ ? kMeasuredDraws : 1);
    for (Answers& answers : draws) {
      for (const Demonstration& demonstration : sample.demonstrations) {
        answers.emplace_back(demonstration.actions.size(), constant_);
        for (std::size_t step = 0; is_stochastic_ && step < answers.back().size(); ++step) {
          answers.back()[step] =
              recorded_[static_cast<std::size_t>(random.random() * static_cast<double>(recorded_.size()))];
        }
      }
    }
    return interview.errorsOf(sample, draws, {});
  }

 private:
  Action constant_;
  bool is_stochastic_;
  std::vector<Action> recorded_;
};

/// Lower bound of the mean of `factor` a - b, at a confidence that holds for `looks` such bounds at once.
double lowerBound(double factor, const std::vector<double>& a, const std::vector<double>& b, std::size_t looks) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < a.size(); ++i) {
    differences.push_back(factor * a[i] - b[i]);
  }
  const Difference difference =
      meanDifference(differences, 1.0 - (1.0 - kConfidence) / static_cast<double>(std::max<std::size_t>(1, looks)));
  return difference.interval ? difference.interval->low : difference.value;
}

/// A finalist of the search, on the episodes that the search did not see.
struct Measured {
  const Trial* trial;
  std::vector<double> errors;  // in each unit

  double mean() const { return averageOf(errors); }
  std::size_t size() const { return trial->corrections.size(); }
};

/// Decision about a policy from its errors in units that the search did not see.
class Decision {
 public:
  Decision(std::vector<double> as_it_is, std::vector<double> constant, std::vector<Measured> finalists)
      : as_it_is_(std::move(as_it_is)), constant_(std::move(constant)), finalists_(std::move(finalists)) {
    std::stable_sort(finalists_.begin(), finalists_.end(),
                     [](const Measured& a, const Measured& b) { return a.mean() < b.mean(); });
  }

  /// The smallest set of corrections that explains the error. One more must explain what the others leave.
  const Measured* named() const {
    const Measured* named = nullptr;
    for (std::size_t size : {std::size_t{1}, std::size_t{2}}) {
      for (const Measured& finalist : finalists_) {
        if (finalist.size() == size && explains(finalist, named == nullptr ? as_it_is_ : named->errors)) {
          named = &finalist;
          break;
        }
      }
    }
    return named;
  }

  /// Whether one explains the error as well as `named`.
  static bool isAlike(const Measured& finalist, const Measured& named) {
    return finalist.size() == named.size() && finalist.mean() <= kAlike * named.mean();
  }

  bool isFar() const { return lowerBound(1.0, as_it_is_, timesFar(), 1) > 0.0; }

  const std::vector<Measured>& finalists() const { return finalists_; }

 private:
  bool explains(const Measured& finalist, const std::vector<double>& others) const {
    return lowerBound(kKept, others, finalist.errors, finalists_.size()) > 0.0 &&
           lowerBound(kExplained, constant_, finalist.errors, finalists_.size()) > 0.0;
  }

  std::vector<double> timesFar() const {
    std::vector<double> bound = constant_;
    for (double& error : bound) {
      error *= kFar;
    }
    return bound;
  }

  std::vector<double> as_it_is_;
  std::vector<double> constant_;
  std::vector<Measured> finalists_;
};

std::vector<std::string> wordsOf(const Corrections& corrections) {
  std::vector<std::string> words;
  for (const Correction* correction : corrections) {
    words.push_back(correction->words);
  }
  return words;
}

bool areFinite(const std::vector<double>& errors) {
  return std::all_of(errors.begin(), errors.end(), [](double error) { return std::isfinite(error); });
}

/// Errors of a policy in each unit of the episodes that the search does not see.
class HeldOut {
 public:
  HeldOut(PolicyInterview& interview, const Sample& sample) : interview_(interview), sample_(sample) {}

  std::vector<double> errorsUnder(const Corrections& corrections) {
    return interview_.errorsOf(sample_, interview_.answersTo(sample_, corrections, kMeasuredDraws), corrections);
  }

  /// Finalists under which all answers are finite.
  std::vector<Measured> measured(const Finalists& finalists) {
    std::vector<Measured> all;
    for (const std::vector<Trial>* trials : {&finalists.singles, &finalists.pairs}) {
      for (const Trial& trial : *trials) {
        all.push_back({&trial, errorsUnder(trial.corrections)});
      }
    }
    all.erase(std::remove_if(all.begin(), all.end(), [](const Measured& one) { return !areFinite(one.errors); }),
              all.end());
    return all;
  }

 private:
  PolicyInterview& interview_;
  const Sample& sample_;
};

std::size_t stepsOf(const std::vector<Demonstration>& demonstrations) {
  std::size_t steps = 0;
  for (const Demonstration& demonstration : demonstrations) {
    steps += demonstration.actions.size();
  }
  return steps;
}

/// Writes the decision and its grounds into `audit`.
void conclude(const Decision& decision, PolicyAudit& audit) {
  const Measured* const named = decision.named();
  for (const Measured& finalist : decision.finalists()) {
    audit.explanations.push_back({wordsOf(finalist.trial->corrections), meanOf(finalist.errors),
                                  named != nullptr && Decision::isAlike(finalist, *named)});
  }
  std::stable_partition(audit.explanations.begin(), audit.explanations.end(),
                        [](const Explanation& explanation) { return explanation.is_named; });
  audit.verdict = named != nullptr   ? PolicyVerdict::kFault
                  : decision.isFar() ? PolicyVerdict::kUnexplained
                                     : PolicyVerdict::kNear;
}

}  // namespace

const char* nameOf(PolicyVerdict verdict) {
  switch (verdict) {
    case PolicyVerdict::kNear:
      return "near";
    case PolicyVerdict::kFault:
      return "fault";
    case PolicyVerdict::kUnexplained:
      return "unexplained";
  }
  throw pusht::InternalError("unknown verdict");
}

std::string PolicyAudit::fault() const {
  return verdict == PolicyVerdict::kFault ? pusht::joined(explanations.front().corrections, "; ") : "";
}

PolicyAudit auditPolicy(pusht::Policy& policy, const PolicySignature& signature,
                        const std::vector<Demonstration>& demonstrations) {
  const std::vector<Unit> units = unitsIn(demonstrations);
  const auto split =
      enough(units.begin(), units.end() - static_cast<std::ptrdiff_t>(kFewestPairs), kSearchedUnits, kSearchedSteps);
  const Sample searched = sampleOf(signature, demonstrations, {units.begin(), split});
  const Sample sample =
      sampleOf(signature, demonstrations, {split, enough(split, units.end(), kFewestPairs, kMeasuredSteps)});
  PolicyInterview interview(policy, signature);
  HeldOut held_out(interview, sample);
  const std::vector<double> as_it_is = held_out.errorsUnder({});
  if (!areFinite(as_it_is)) {
    throw pusht::BadDependency("its answers to recorded observations must be finite numbers");
  }
  const Blind blind(searched, signature.is_stochastic);
  const std::vector<double> of_constant = blind.errorsIn(interview, sample);

  PolicyAudit audit;
  audit.signature = signature;
  audit.episodes = demonstrations.size();
  audit.steps = stepsOf(demonstrations);
  audit.units = sample.units.size();
  audit.draws = signature.is_stochastic ? kMeasuredDraws : 1;
  audit.are_episodes = units.size() == demonstrations.size();
  audit.error = meanOf(as_it_is);
  audit.constant = meanOf(of_constant);
  const std::vector<Correction> questions = questionCorrections(signature, demonstrations);
  const std::vector<Correction> answers = answerCorrections(signature, demonstrations);
  const Finalists finalists =
      searchFaults(interview, questions, answers, searched, averageOf(blind.errorsIn(interview, searched)));
  audit.tried = finalists.tried;
  conclude(Decision(as_it_is, of_constant, held_out.measured(finalists)), audit);
  return audit;
}

}  // namespace sim2sim
