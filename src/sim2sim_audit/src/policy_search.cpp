// SPDX-License-Identifier: BSD-3-Clause
#include "policy_search.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

constexpr std::size_t kQuickSteps = 64;    // of the first round
constexpr std::size_t kSurvivors = 32;     // of the first round
constexpr std::size_t kFinalists = 3;      // of each size
constexpr int kSearchDraws = 8;            // of a policy's random numbers
constexpr std::size_t kBestQuestions = 2;  // to which every other question's correction is added
// An error may be that of a fault beyond one of these shares.
constexpr double kHelped = 0.85;  // of the error as it is, under the best correction
constexpr double kNear = 0.55;    // of the error of a constant action

bool isBetter(const Trial& a, const Trial& b) { return a.error < b.error; }

/// The best ones first. Of equal errors, as of corrections that change nothing here, the first one counts.
std::vector<Trial> best(std::vector<Trial> trials, std::size_t count) {
  std::stable_sort(trials.begin(), trials.end(), isBetter);
  trials.resize(std::min(count, trials.size()));
  return trials;
}

/// Parts of some units, for the first round: each from another phase of its unit. A policy with a state must be shown
/// all that comes before, so fewer and early ones do.
std::vector<Unit> glimpsesOf(const Sample& sample, bool has_state) {
  const std::size_t count = has_state ? 2 : 4;
  const std::size_t steps = kQuickSteps / count;
  constexpr std::size_t kPhases = 4;
  std::vector<Unit> glimpses;
  for (std::size_t i = 0; i < std::min(count, sample.units.size()); ++i) {
    Unit unit = sample.units[i * sample.units.size() / count];
    const std::size_t spare = unit.steps() - std::min(steps, unit.steps());
    unit.begin += spare * i / kPhases;
    unit.end = std::min(unit.end, unit.begin + steps);
    glimpses.push_back(unit);
  }
  return glimpses;
}

Corrections together(const Corrections& a, const Corrections& b) {
  Corrections all = a;
  all.insert(all.end(), b.begin(), b.end());
  std::stable_sort(all.begin(), all.end(),
                   [](const Correction* one, const Correction* other) { return one->group < other->group; });
  return all;
}

bool canBeTogether(const Correction& a, const Correction& b) { return a.group != b.group; }

class Search {
 public:
  Search(PolicyInterview& policy, const std::vector<Correction>& questions, const std::vector<Correction>& answers,
         const Sample& sample, double constant)
      : policy_(policy),
        questions_(questions),
        answers_(answers),
        sample_(sample),
        quick_(sampleOf(policy.signature(), sample.demonstrations, glimpsesOf(sample, policy.signature().has_state))),
        constant_(constant) {}

  Finalists run() {
    const double as_it_is = errorOn(sample_, {});
    ask({});
    for (const Correction& question : questions_) {
      ask({&question});
    }
    Finalists finalists;
    finalists.singles = confirmed(trials_[0]);
    refine(finalists.singles.front());
    const double best_single = finalists.singles.front().error;
    if (best_single < kHelped * as_it_is || as_it_is > kNear * constant_) {
      addToTheBest();
    }
    if (std::min(best_single, as_it_is) > kNear * constant_) {
      askCommonPairs();
    }
    finalists.pairs = confirmed(trials_[1]);
    finalists.tried = tried_;
    finalists.refined = std::move(refined_);
    return finalists;
  }

 private:
  double errorOn(const Sample& sample, const Corrections& corrections) {
    return averageOf(policy_.errorsOf(sample, policy_.answersTo(sample, corrections, kSearchDraws), corrections));
  }

  /// Asks the policy under corrections of questions, and reads the answers in all ways.
  void ask(const Corrections& questions) {
    const Draws answers = policy_.answersTo(quick_, questions, kSearchDraws);
    const auto read = [&](const Corrections& corrections) {
      if (!corrections.empty()) {
        ++tried_;
        trials_[corrections.size() - 1].push_back(
            {corrections, averageOf(policy_.errorsOf(quick_, answers, corrections))});
      }
    };
    read(questions);
    if (questions.size() < 2) {
      for (const Correction& answer : answers_) {
        read(together(questions, {&answer}));
      }
    }
    if (questions.empty()) {
      askPairsOfAnswers(answers);
    }
  }

  void askPairsOfAnswers(const Draws& answers) {
    for (auto one = answers_.begin(); one != answers_.end(); ++one) {
      for (auto other = one + 1; other != answers_.end(); ++other) {
        if (canBeTogether(*one, *other)) {
          const Corrections pair = together({&*one}, {&*other});
          ++tried_;
          trials_[1].push_back({pair, averageOf(policy_.errorsOf(quick_, answers, pair))});
        }
      }
    }
  }

  /// Moves to the best neighbor as long as there are finer ones.
  void refine(Trial& trial) {
    while (trial.corrections.front()->neighbors) {
      std::vector<Trial> around;
      for (Correction& neighbor : trial.corrections.front()->neighbors()) {
        refined_.push_back(std::move(neighbor));
        around.push_back({{&refined_.back()}, errorOn(sample_, {&refined_.back()})});
      }
      tried_ += around.size();
      trial = best(around, 1).front();
    }
  }

  /// Adds each question's correction to the best ones.
  void addToTheBest() {
    for (const Trial& trial : best(questionsAlone(), kBestQuestions)) {
      for (const Correction& other : questions_) {
        askPair(*trial.corrections.front(), other);
      }
    }
  }

  void askCommonPairs() {
    for (auto one = questions_.begin(); one != questions_.end(); ++one) {
      for (auto other = one + 1; one->is_common && other != questions_.end(); ++other) {
        if (other->is_common) {
          askPair(*one, *other);
        }
      }
    }
  }

  void askPair(const Correction& one, const Correction& other) {
    if (canBeTogether(one, other)) {
      ask(together({&one}, {&other}));
    }
  }

  std::vector<Trial> questionsAlone() const {
    std::vector<Trial> alone;
    std::copy_if(trials_[0].begin(), trials_[0].end(), std::back_inserter(alone),
                 [](const Trial& trial) { return trial.corrections.front()->isOfQuestion(); });
    return alone;
  }

  /// The best of the first round, by the whole sample.
  std::vector<Trial> confirmed(const std::vector<Trial>& trials) {
    std::vector<Trial> survivors = best(trials, kSurvivors);
    for (Trial& trial : survivors) {
      trial.error = errorOn(sample_, trial.corrections);
    }
    return best(survivors, kFinalists);
  }

  PolicyInterview& policy_;
  const std::vector<Correction>& questions_;
  const std::vector<Correction>& answers_;
  const Sample& sample_;
  Sample quick_;
  double constant_;
  std::array<std::vector<Trial>, 2> trials_;  // of the first round: of one correction, of two
  std::size_t tried_ = 0;
  std::list<Correction> refined_;
};

}  // namespace

Finalists searchFaults(PolicyInterview& policy, const std::vector<Correction>& questions,
                       const std::vector<Correction>& answers, const Sample& sample, double constant) {
  return Search(policy, questions, answers, sample, constant).run();
}

}  // namespace sim2sim
