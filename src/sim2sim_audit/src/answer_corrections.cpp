// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "columns.hpp"
#include "policy_correction.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"

namespace sim2sim {
namespace {

using pusht::Action;
using pusht::Observation;
constexpr std::size_t kActionNumbers = std::tuple_size<Action>::value;

/// Corrections as they are added.
class AnswerList {
 public:
  void add(Correction::Group group, const std::string& words,
           std::function<Action(const Action&, const Observation&)> change) {
    Correction correction{group, words};
    correction.action = std::move(change);
    corrections_.push_back(std::move(correction));
  }

  /// A change that does not depend on what was observed.
  template <class Change>
  void addBlind(Correction::Group group, const std::string& words, const Change& change) {
    add(group, words, [change](const Action& action, const Observation&) { return change(action); });
  }

  void addChunk(const std::string& words, std::function<Correction::Actions(const Correction::Actions&)> change) {
    Correction correction{Correction::Group::kChunk, words};
    correction.chunk = std::move(change);
    corrections_.push_back(std::move(correction));
  }

  void addTime(const std::string& words, int later) {
    Correction correction{Correction::Group::kTime, words};
    correction.later = later;
    corrections_.push_back(std::move(correction));
  }

  std::vector<Correction> take() { return std::move(corrections_); }

 private:
  std::vector<Correction> corrections_;
};

Action linear(const Action& action, double xx, double xy, double yx, double yy) {
  return {static_cast<float>(xx * action[0] + xy * action[1]), static_cast<float>(yx * action[0] + yy * action[1])};
}

void addActionScales(AnswerList& list) {
  for (const double factor : {1000.0, 100.0, 10.0, 5.0, 3.0, 2.0, 1.5}) {
    for (const double scaled : {factor, 1.0 / factor}) {
      const std::string note = scaled == 10.0 ? " (they are ways of a control step, not velocities)" : "";
      list.addBlind(Correction::Group::kActionScale, "actions times " + pusht::significantText(scaled, 3) + note,
                    [scaled](const Action& action) { return linear(action, scaled, 0.0, 0.0, scaled); });
    }
  }
}

void addActionAxes(AnswerList& list) {
  struct Turn {
    const char* words;
    double xx, xy, yx, yy;
  };
  constexpr std::array kTurns = {
      Turn{"the other sign of x of actions", -1.0, 0.0, 0.0, 1.0},
      Turn{"the other sign of y of actions", 1.0, 0.0, 0.0, -1.0},
      Turn{"the other sign of actions", -1.0, 0.0, 0.0, -1.0},
      Turn{"x and y of actions swapped", 0.0, 1.0, 1.0, 0.0},
      Turn{"actions turned by 90 deg", 0.0, -1.0, 1.0, 0.0},
      Turn{"actions turned by -90 deg", 0.0, 1.0, -1.0, 0.0},
  };
  for (const Turn& turn : kTurns) {
    list.addBlind(Correction::Group::kActionAxes, turn.words,
                  [turn](const Action& action) { return linear(action, turn.xx, turn.xy, turn.yx, turn.yy); });
  }
  constexpr std::size_t kSine = 4;  // of the tee's yaw, in an observation
  constexpr std::size_t kCosine = 5;
  list.add(Correction::Group::kActionAxes, "actions turned from the tee's axes into the table's",
           [](const Action& action, const Observation& at) {
             return linear(action, at[kCosine], -at[kSine], at[kSine], at[kCosine]);
           });
  list.add(Correction::Group::kActionAxes, "actions turned from the table's axes into the tee's",
           [](const Action& action, const Observation& at) {
             return linear(action, at[kCosine], at[kSine], -at[kSine], at[kCosine]);
           });
}

/// Whether a normalization hardly changes the recorded actions.
bool isNearlyNone(const Normalization<kActionNumbers>& way, const std::vector<Demonstration>& demonstrations) {
  constexpr double kLittle = 0.1;
  double change = 0.0;
  double size = 0.0;
  for (const Demonstration& demonstration : demonstrations) {
    for (const Action& action : demonstration.actions) {
      const Action normalized = way.normalized(action);
      for (std::size_t axis = 0; axis < kActionNumbers; ++axis) {
        change += std::abs(normalized[axis] - action[axis]);
        size += std::abs(action[axis]);
      }
    }
  }
  return change < kLittle * size;
}

void addMeanings(AnswerList& list, const std::vector<Demonstration>& demonstrations) {
  list.add(Correction::Group::kMeaning, "actions taken as positions to be reached in a control step",
           [](const Action& action, const Observation& at) -> Action {
             const auto step = static_cast<float>(pusht::kControlStep);
             return {(action[0] - at[0]) / step, (action[1] - at[1]) / step};
           });
  Columns<kActionNumbers> columns;
  for (const Demonstration& demonstration : demonstrations) {
    for (const Action& action : demonstration.actions) {
      columns.add(action);
    }
  }
  const std::vector<std::pair<std::string, Normalization<kActionNumbers>>> ways = {
      {"to [-1, 1]", columns.toSignedUnit()},
      {"to [0, 1]", columns.toUnit()},
      {"to mean 0 and deviation 1", columns.toStandard()}};
  for (const auto& [name, way] : ways) {
    if (isNearlyNone(way, demonstrations)) {
      continue;
    }
    list.addBlind(Correction::Group::kMeaning, "a normalization of actions " + name + " undone",
                  [way = way](const Action& action) { return way.inSiUnits(action); });
    list.addBlind(Correction::Group::kMeaning, "a normalization of actions " + name + " undone once less",
                  [way = way](const Action& action) { return way.normalized(action); });
  }
}

void addTimes(AnswerList& list) {
  for (const int steps : {1, 2, 3, 4}) {
    const std::string count = std::to_string(steps) + (steps == 1 ? " step" : " steps");
    list.addTime("actions " + count + " earlier (observations or actions come late)", -steps);
    list.addTime("actions " + count + " later (observations or actions come early)", steps);
  }
}

void addChunks(AnswerList& list) {
  list.addChunk("the last action of an answer first", [](Correction::Actions actions) {
    std::reverse(actions.begin(), actions.end());
    return actions;
  });
  list.addChunk("x and y together, as an answer has all x before all y",
                [](const Correction::Actions& actions) { return untransposed(actions); });
  list.addChunk("all x of an answer before all y",
                [](const Correction::Actions& actions) { return transposed(actions); });
}

}  // namespace

std::vector<Correction> answerCorrections(const PolicySignature& signature,
                                          const std::vector<Demonstration>& demonstrations) {
  AnswerList list;
  if (signature.actions > 1) {
    addChunks(list);
  }
  addTimes(list);
  addMeanings(list, demonstrations);
  addActionAxes(list);
  addActionScales(list);
  return list.take();
}

}  // namespace sim2sim
