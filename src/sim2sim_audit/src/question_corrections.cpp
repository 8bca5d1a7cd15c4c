// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <string>
#include <utility>

#include "columns.hpp"
#include "policy_correction.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"

namespace sim2sim {
namespace {

using pusht::Observation;

constexpr std::size_t kNumbers = std::tuple_size<Observation>::value;
constexpr std::size_t kPairs = kNumbers / 2;

// Pairs of numbers in an observation.
constexpr std::size_t kPusher = 0;
constexpr std::size_t kTee = 1;
constexpr std::size_t kTeeAngle = 2;
constexpr std::size_t kTarget = 3;
constexpr std::size_t kTargetAngle = 4;
constexpr std::array<std::size_t, 3> kPositions = {kPusher, kTee, kTarget};
constexpr std::array<std::size_t, 2> kAngles = {kTeeAngle, kTargetAngle};
const std::array<std::string, kPairs> kPairNames = {"pusher", "tee", "tee's angle", "target", "target's angle"};

float& first(Observation& observation, std::size_t pair) { return observation[2 * pair]; }
float& second(Observation& observation, std::size_t pair) { return observation[2 * pair + 1]; }

/// Corrections as they are added.
class QuestionList {
 public:
  using Change = std::function<void(Observation&)>;

  void add(Correction::Group group, const std::string& words, const Change& change, bool is_common = true) {
    Correction correction{group, words, is_common};
    correction.observation = [change](Observation observation) {
      change(observation);
      return observation;
    };
    corrections_.push_back(std::move(correction));
  }

  void add(Correction correction) { corrections_.push_back(std::move(correction)); }

  /// A change of each of these pairs, which gets both numbers.
  template <class Pairs, class ChangeOfPair>
  void addOfPairs(Correction::Group group, const std::string& words, const Pairs& pairs, const ChangeOfPair& change) {
    add(group, words, [pairs, change](Observation& observation) {
      for (const std::size_t pair : pairs) {
        change(first(observation, pair), second(observation, pair));
      }
    });
  }

  void addHistory(const std::string& words, std::function<Correction::Observations(Correction::Observations)> change) {
    Correction correction{Correction::Group::kHistory, words};
    correction.history = std::move(change);
    corrections_.push_back(std::move(correction));
  }

  std::vector<Correction> take() { return std::move(corrections_); }

 private:
  std::vector<Correction> corrections_;
};

/// "pusher and tee swapped", or all names in their order.
std::string wordsOf(const std::array<std::size_t, kPairs>& order) {
  std::vector<std::string> moved;
  std::vector<std::string> all;
  for (std::size_t place = 0; place < kPairs; ++place) {
    all.push_back(kPairNames[order[place]]);
    if (order[place] != place) {
      moved.push_back(kPairNames[place]);
    }
  }
  return moved.size() == 2 ? moved[0] + " and " + moved[1] + " swapped" : "the order " + pusht::joined(all);
}

void addOrders(QuestionList& list) {
  std::array<std::size_t, kPairs> order{};
  std::iota(order.begin(), order.end(), std::size_t{0});
  while (std::next_permutation(order.begin(), order.end())) {
    const std::string words = wordsOf(order);
    const bool is_swap = words.find(" swapped") != std::string::npos;
    list.add(
        Correction::Group::kOrder, words,
        [order](Observation& observation) {
          Observation recorded = observation;
          for (std::size_t place = 0; place < kPairs; ++place) {
            first(observation, place) = first(recorded, order[place]);
            second(observation, place) = second(recorded, order[place]);
          }
        },
        is_swap);
  }
  const auto swap = [](float& a, float& b) { std::swap(a, b); };
  list.addOfPairs(Correction::Group::kWithinPairs, "sine and cosine swapped", kAngles, swap);
  list.addOfPairs(Correction::Group::kWithinPairs, "sine and cosine of the tee swapped", std::array{kTeeAngle}, swap);
  list.addOfPairs(Correction::Group::kWithinPairs, "x and y of all positions swapped", kPositions, swap);
  list.addOfPairs(Correction::Group::kWithinPairs, "x and y of the pusher swapped", std::array{kPusher}, swap);
  list.addOfPairs(Correction::Group::kWithinPairs, "x and y of the tee swapped", std::array{kTee}, swap);
  list.add(Correction::Group::kOrder, "the last number first",
           [](Observation& observation) { std::reverse(observation.begin(), observation.end()); });
  // x of pusher, tee and target, then y of them; and the inverse.
  constexpr std::array<std::size_t, kNumbers> kAxisByAxis = {0, 2, 6, 1, 3, 7, 4, 5, 8, 9};
  list.add(Correction::Group::kOrder, "all x before all y", [kAxisByAxis](Observation& observation) {
    const Observation recorded = observation;
    for (std::size_t i = 0; i < kNumbers; ++i) {
      observation[i] = recorded[kAxisByAxis[i]];
    }
  });
  list.add(Correction::Group::kOrder, "x and y together, as they come with all x before all y",
           [kAxisByAxis](Observation& o) {
             const Observation recorded = o;
             for (std::size_t i = 0; i < kNumbers; ++i) {
               o[kAxisByAxis[i]] = recorded[i];
             }
           });
}

/// Number times a factor: "times 1000 (mm)".
std::string timesText(double factor, bool is_length) {
  std::string times = "times " + pusht::significantText(factor, 3);
  if (!is_length) {
    return times;
  }
  return times + (factor == 1000.0 ? " (mm)" : factor == 100.0 ? " (cm)" : "");
}

void addUnits(QuestionList& list) {
  struct Factor {
    double factor;
    bool is_common;
  };
  constexpr std::array<Factor, 7> kFactors = {
      {{1000.0, true}, {100.0, true}, {10.0, false}, {5.0, false}, {3.0, false}, {2.0, true}, {1.5, false}}};
  const auto scaled = [&](const std::string& what, const auto& pairs, double factor, bool is_common) {
    list.add(
        Correction::Group::kUnits, what + " " + timesText(factor, pairs.size() < kPairs),
        [pairs, factor](Observation& observation) {
          for (const std::size_t pair : pairs) {
            first(observation, pair) = static_cast<float>(first(observation, pair) * factor);
            second(observation, pair) = static_cast<float>(second(observation, pair) * factor);
          }
        },
        is_common);
  };
  for (const Factor& factor : kFactors) {
    for (const double times : {factor.factor, 1.0 / factor.factor}) {
      scaled("positions", kPositions, times, factor.is_common);
      scaled("the pusher's position", std::array{kPusher}, times, false);
      scaled("the tee's position", std::array{kTee}, times, false);
      scaled("all numbers", std::array<std::size_t, kPairs>{0, 1, 2, 3, 4}, times, false);
    }
  }
}

/// Positions moved [m]; its neighbors are half as far apart as `step`.
Correction originMoved(double dx, double dy, double step) {
  constexpr double kLeastStep = 0.01;  // [m]
  Correction correction{Correction::Group::kOrigin,
                        "positions moved by (" + pusht::fixedText(dx, 2) + ", " + pusht::fixedText(dy, 2) + ") m",
                        false};
  correction.observation = [dx, dy](Observation observation) {
    for (const std::size_t pair : kPositions) {
      first(observation, pair) += static_cast<float>(dx);
      second(observation, pair) += static_cast<float>(dy);
    }
    return observation;
  };
  if (step > kLeastStep) {
    correction.neighbors = [dx, dy, half = step / 2.0] {
      std::vector<Correction> neighbors;
      for (const double x : {dx - half, dx, dx + half}) {
        for (const double y : {dy - half, dy, dy + half}) {
          neighbors.push_back(originMoved(x, y, half));
        }
      }
      return neighbors;
    };
  }
  return correction;
}

void addOrigins(QuestionList& list) {
  constexpr int kSteps = 5;
  constexpr double kStep = 0.1;  // [m]
  for (int x = -kSteps; x <= kSteps; ++x) {
    for (int y = -kSteps; y <= kSteps; ++y) {
      if (x != 0 || y != 0) {
        list.add(originMoved(kStep * x, kStep * y, kStep));
      }
    }
  }
}

void addAngles(QuestionList& list) {
  constexpr double kDegree = pusht::kPi / 180.0;
  const auto of_angle = [](const std::function<void(double, float&, float&)>& change) {
    return [change](float& sine, float& cosine) { change(std::atan2(sine, cosine), sine, cosine); };
  };
  const auto scaled = [&](double factor) {
    return of_angle([factor](double yaw, float& sine, float& cosine) {
      sine = static_cast<float>(std::sin(factor * yaw));
      cosine = static_cast<float>(std::cos(factor * yaw));
    });
  };
  const auto turned = [&](double turn) {
    return of_angle([turn](double yaw, float& sine, float& cosine) {
      sine = static_cast<float>(std::sin(yaw + turn));
      cosine = static_cast<float>(std::cos(yaw + turn));
    });
  };
  const auto plain = [&](double factor, float second_number) {
    return of_angle([factor, second_number](double yaw, float& sine, float& cosine) {
      sine = static_cast<float>(factor * yaw);
      cosine = second_number;
    });
  };
  list.addOfPairs(Correction::Group::kAngle, "sine and cosine of the angle in degrees", kAngles, scaled(1.0 / kDegree));
  list.addOfPairs(Correction::Group::kAngle, "sine and cosine of an angle that was taken for degrees", kAngles,
                  scaled(kDegree));
  list.addOfPairs(Correction::Group::kAngle, "sine and cosine of half the angle", kAngles, scaled(0.5));
  list.addOfPairs(Correction::Group::kAngle, "sine and cosine of twice the angle", kAngles, scaled(2.0));
  for (const float other : {0.0F, 1.0F}) {
    const std::string beside = other == 0.0F ? ", 0 in place of the cosine" : ", 1 in place of the cosine";
    list.addOfPairs(Correction::Group::kAngle, "the angle [rad] in place of its sine" + beside, kAngles,
                    plain(1.0, other));
    list.addOfPairs(Correction::Group::kAngle, "the angle [deg] in place of its sine" + beside, kAngles,
                    plain(1.0 / kDegree, other));
  }
  list.addOfPairs(Correction::Group::kAngle, "the other sign of the sine", kAngles,
                  [](float& sine, float&) { sine = -sine; });
  list.addOfPairs(Correction::Group::kAngle, "the other sign of the cosine", kAngles,
                  [](float&, float& cosine) { cosine = -cosine; });
  list.addOfPairs(Correction::Group::kAngle, "the tee's angle turned by 180 deg", std::array{kTeeAngle},
                  turned(pusht::kPi));
  list.addOfPairs(Correction::Group::kAngle, "angles turned by 180 deg", kAngles, turned(pusht::kPi));
  list.addOfPairs(Correction::Group::kAngle, "angles turned by 90 deg", kAngles, turned(pusht::kPi / 2));
  list.addOfPairs(Correction::Group::kAngle, "angles turned by -90 deg", kAngles, turned(-pusht::kPi / 2));
}

void addAxes(QuestionList& list) {
  const auto other_x = [](float& x, float&) { x = -x; };
  const auto other_y = [](float&, float& y) { y = -y; };
  const auto other_both = [](float& x, float& y) {
    x = -x;
    y = -y;
  };
  const std::vector<std::pair<std::string, std::vector<std::size_t>>> subjects = {
      {"all positions", {kPusher, kTee, kTarget}},
      {"the pusher's position", {kPusher}},
      {"the tee's position", {kTee}}};
  for (const auto& [name, pairs] : subjects) {
    list.addOfPairs(Correction::Group::kAxes, "the other sign of x of " + name, pairs, other_x);
    list.addOfPairs(Correction::Group::kAxes, "the other sign of y of " + name, pairs, other_y);
    list.addOfPairs(Correction::Group::kAxes, "the other sign of x and y of " + name, pairs, other_both);
  }
  const auto turned = [](double turn) {
    return [turn](Observation& observation) {
      const auto turn_pair = [turn](float& x, float& y) {
        const double old_x = x;
        x = static_cast<float>(std::cos(turn) * old_x - std::sin(turn) * y);
        y = static_cast<float>(std::sin(turn) * old_x + std::cos(turn) * y);
      };
      for (const std::size_t pair : kPositions) {
        turn_pair(first(observation, pair), second(observation, pair));
      }
      for (const std::size_t pair : kAngles) {
        turn_pair(second(observation, pair), first(observation, pair));
      }
    };
  };
  list.add(Correction::Group::kAxes, "the table turned by 90 deg", turned(pusht::kPi / 2));
  list.add(Correction::Group::kAxes, "the table turned by -90 deg", turned(-pusht::kPi / 2));
  list.add(Correction::Group::kAxes, "the table turned by 180 deg", turned(pusht::kPi));
}

void addFrames(QuestionList& list) {
  const auto moved = [](std::size_t pair, std::size_t by, float sign) {
    return [pair, by, sign](Observation& observation) {
      first(observation, pair) += sign * first(observation, by);
      second(observation, pair) += sign * second(observation, by);
    };
  };
  list.add(Correction::Group::kFrame, "the tee's position relative to the pusher", moved(kTee, kPusher, -1.0F));
  list.add(Correction::Group::kFrame, "the tee's position on the table, as it comes relative to the pusher",
           moved(kTee, kPusher, 1.0F));
  list.add(Correction::Group::kFrame, "the pusher's position relative to the tee", moved(kPusher, kTee, -1.0F));
  list.add(Correction::Group::kFrame, "the pusher's position on the table, as it comes relative to the tee",
           moved(kPusher, kTee, 1.0F));
  for (const float sign : {1.0F, -1.0F}) {
    const char* const words = sign > 0.0F ? "the tee's center of mass in place of its origin"
                                          : "the tee's origin, as its center of mass comes";
    list.add(Correction::Group::kFrame, words, [sign](Observation& observation) {
      const auto offset = sign * static_cast<float>(pusht::kCenterOfMassOffset);
      first(observation, kTee) += offset * first(observation, kTeeAngle);  // (0, -offset) turned by the yaw
      second(observation, kTee) -= offset * second(observation, kTeeAngle);
    });
  }
}

void addNormalizations(QuestionList& list, const std::vector<Demonstration>& demonstrations) {
  Columns<kNumbers> columns;
  for (const Demonstration& demonstration : demonstrations) {
    for (const Observation& observation : demonstration.observations) {
      columns.add(observation);
    }
  }
  const std::vector<std::pair<std::string, Normalization<kNumbers>>> ways = {
      {"to [-1, 1]", columns.toSignedUnit()},
      {"to [0, 1]", columns.toUnit()},
      {"to mean 0 and deviation 1", columns.toStandard()}};
  for (const auto& [name, way] : ways) {
    list.add(Correction::Group::kNormalization, "observations normalized " + name,
             [way = way](Observation& observation) { observation = way.normalized(observation); });
    list.add(Correction::Group::kNormalization, "one normalization " + name + " taken off",
             [way = way](Observation& observation) { observation = way.inSiUnits(observation); });
  }
}

void addHistories(QuestionList& list) {
  list.addHistory("the newest observation first", [](Correction::Observations past) {
    std::reverse(past.begin(), past.end());
    return past;
  });
  list.addHistory("the history number by number",
                  [](const Correction::Observations& past) { return transposed(past); });
  list.addHistory("the history observation by observation, as it comes number by number",
                  [](const Correction::Observations& past) { return untransposed(past); });
}

}  // namespace

std::vector<Correction> questionCorrections(const PolicySignature& signature,
                                            const std::vector<Demonstration>& demonstrations) {
  QuestionList list;
  addNormalizations(list, demonstrations);
  addOrders(list);
  addFrames(list);
  addOrigins(list);
  addUnits(list);
  addAngles(list);
  addAxes(list);
  if (signature.observations > 1 && !signature.has_state) {
    addHistories(list);
  }
  return list.take();
}

}  // namespace sim2sim
