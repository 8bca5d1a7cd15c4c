// SPDX-License-Identifier: BSD-3-Clause
#include "planted_policy_faults.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <utility>

#include "pusht_task/constants.hpp"

namespace sim2sim::testing {
namespace {

using pusht::Action;
using pusht::Observation;
using pusht::Policy;
using Actions = std::vector<Action>;
using Observations = std::vector<Observation>;

/// What a faulty policy remembers of a rollout.
struct FaultyMemory : Policy::Memory {
  std::unique_ptr<Policy::Memory> memory{};  // of a policy with a state
  std::uint64_t seed = 0;
  Observations past{};
  std::deque<Action> answer{};  // what is left of it
  std::deque<Action> late{};    // on their way
};

class FaultyPolicy final : public Policy {
 public:
  FaultyPolicy(Policy& policy, const PolicySignature& signature, std::vector<PolicyFault> faults)
      : policy_(policy), signature_(signature), faults_(std::move(faults)) {}

  std::unique_ptr<Memory> begin(const pusht::Beginning& beginning) const override {
    auto memory = std::make_unique<FaultyMemory>();
    memory->memory = policy_.begin({beginning.seed, 1});
    memory->seed = beginning.seed;
    return memory;
  }

  void act(pusht::Span<const Query> queries, pusht::Span<Action> actions) override {
    std::vector<FaultyMemory*> spent;
    for (const Query& query : queries) {
      auto& memory = static_cast<FaultyMemory&>(*query.memory);
      memory.past.resize(memory.past.empty() ? past() : memory.past.size(), query.observation);
      std::rotate(memory.past.begin(), memory.past.begin() + 1, memory.past.end());
      memory.past.back() = query.observation;
      if (memory.answer.empty()) {
        spent.push_back(&memory);
      }
    }
    answer(spent);
    for (std::size_t i = 0; i < queries.size(); ++i) {
      actions[i] = next(static_cast<FaultyMemory&>(*queries[i].memory));
    }
  }

 private:
  std::size_t past() const { return static_cast<std::size_t>(signature_.observations); }
  std::size_t chunk() const { return static_cast<std::size_t>(signature_.actions); }

  Observations seen(Observations past) const {
    for (const PolicyFault& fault : faults_) {
      if (fault.observation) {
        std::transform(past.begin(), past.end(), past.begin(), fault.observation);
      }
      past = fault.history ? fault.history(past) : past;
    }
    return past;
  }

  /// A policy without a state is asked in a rollout of its own, whose call is the first one that sees the whole past.
  void answer(const std::vector<FaultyMemory*>& spent) {
    const std::size_t call = signature_.has_state ? 0 : (past() - 1 + chunk() - 1) / chunk() * chunk();
    std::vector<std::unique_ptr<Memory>> own;
    std::vector<Observations> shown;
    for (FaultyMemory* memory : spent) {
      const Observations past = seen(memory->past);
      shown.emplace_back(call + 1 - past.size(), past.front());
      shown.back().insert(shown.back().end(), past.begin(), past.end());
      shown.back().resize(call + chunk(), past.back());
      own.push_back(signature_.has_state ? nullptr : policy_.begin({memory->seed++, signature_.actions}));
    }
    std::vector<Query> queries(spent.size());
    Actions actions(spent.size());
    std::vector<Actions> answers(spent.size());
    for (std::size_t step = 0; step < call + chunk() && !spent.empty(); ++step) {
      for (std::size_t i = 0; i < spent.size(); ++i) {
        queries[i] = {shown[i][step], signature_.has_state ? spent[i]->memory.get() : own[i].get()};
      }
      policy_.act(queries, actions);
      for (std::size_t i = 0; i < spent.size() && step >= call; ++i) {
        answers[i].push_back(actions[i]);
      }
    }
    for (std::size_t i = 0; i < spent.size(); ++i) {
      spent[i]->answer = changed(answers[i]);
    }
  }

  std::deque<Action> changed(Actions answer) const {
    for (auto fault = faults_.rbegin(); fault != faults_.rend(); ++fault) {
      answer = fault->chunk ? fault->chunk(answer) : answer;
    }
    return {answer.begin(), answer.end()};
  }

  Action next(FaultyMemory& memory) const {
    Action action = memory.answer.front();
    memory.answer.pop_front();
    std::size_t delay = 0;
    for (auto fault = faults_.rbegin(); fault != faults_.rend(); ++fault) {
      action = fault->action ? fault->action(action, memory.past.back()) : action;
      delay += static_cast<std::size_t>(fault->delay);
    }
    if (delay == 0) {
      return action;
    }
    memory.late.resize(memory.late.empty() ? delay : memory.late.size(), Action{});
    memory.late.push_back(action);
    action = memory.late.front();
    memory.late.pop_front();
    return action;
  }

  Policy& policy_;
  PolicySignature signature_;
  std::vector<PolicyFault> faults_;
};

// Faults.

PolicyFault ofObservation(const std::string& name, const std::string& named_by,
                          const std::function<void(Observation&)>& change) {
  PolicyFault fault{name, named_by};
  fault.observation = [change](Observation observation) {
    change(observation);
    return observation;
  };
  return fault;
}

PolicyFault ofAction(const std::string& name, const std::string& named_by,
                     std::function<Action(Action, const Observation&)> change) {
  PolicyFault fault{name, named_by};
  fault.action = std::move(change);
  return fault;
}

PolicyFault ofDelay(int steps, const std::string& named_by) {
  PolicyFault fault{"actions " + std::to_string(steps) + " control steps late", named_by};
  fault.delay = steps;
  return fault;
}

std::function<void(Observation&)> scaled(float factor) {
  return [factor](Observation& o) {
    for (const std::size_t i : {0, 1, 2, 3, 6, 7}) {
      o[i] *= factor;
    }
  };
}

std::function<void(Observation&)> angleTimes(double factor, double turn) {
  return [factor, turn](Observation& o) {
    for (const std::size_t i : {4, 8}) {
      const double angle = factor * std::atan2(o[i], o[i + 1]) + turn;
      o[i] = static_cast<float>(std::sin(angle));
      o[i + 1] = static_cast<float>(std::cos(angle));
    }
  };
}

void addOfObservations(std::vector<PolicyFault>& faults) {
  faults.push_back(ofObservation("pusher and tee swapped", "pusher and tee swapped", [](Observation& o) {
    std::swap(o[0], o[2]);
    std::swap(o[1], o[3]);
  }));
  faults.push_back(ofObservation("sine and cosine swapped", "sine and cosine swapped", [](Observation& o) {
    std::swap(o[4], o[5]);
    std::swap(o[8], o[9]);
  }));
  faults.push_back(ofObservation("target first", "the order tee, tee's angle, target, target's angle, pusher",
                                 [](Observation& o) {  // target, its angle, pusher, tee, its angle
                                   std::rotate(o.begin(), o.begin() + 8, o.end());
                                 }));
  faults.push_back(ofObservation("x and y swapped", "x and y of all positions swapped", [](Observation& o) {
    for (const std::size_t i : {0, 2, 6}) {
      std::swap(o[i], o[i + 1]);
    }
  }));
  faults.push_back(ofObservation("sign of the sine", "the other sign of the sine", [](Observation& o) {
    o[4] = -o[4];
    o[8] = -o[8];
  }));
  faults.push_back(ofObservation("sign of the cosine", "the other sign of the cosine", [](Observation& o) {
    o[5] = -o[5];
    o[9] = -o[9];
  }));
  faults.push_back(ofObservation("sign of x", "the other sign of x of all positions", [](Observation& o) {
    for (const std::size_t i : {0, 2, 6}) {
      o[i] = -o[i];
    }
  }));
  faults.push_back(ofObservation("sign of the tee's y", "the other sign of y of the tee's position",
                                 [](Observation& o) { o[3] = -o[3]; }));
  faults.push_back(ofObservation("positions halved", "positions times 2", scaled(0.5F)));
  faults.push_back(ofObservation("positions in mm", "positions times 0.001", scaled(1000.0F)));
  faults.push_back(ofObservation("positions in m for a policy of cm", "positions times 100 (cm)", scaled(0.01F)));
  faults.push_back(ofObservation("origin in a corner", "positions moved by (-0.", [](Observation& o) {
    for (const std::size_t i : {0, 1, 2, 3, 6, 7}) {
      o[i] += 0.39F;
    }
  }));
  faults.push_back(ofObservation("trained with a yaw taken for degrees",
                                 "sine and cosine of an angle that was taken for degrees",
                                 angleTimes(180.0 / pusht::kPi, 0.0)));
  faults.push_back(ofObservation("yaw from another axis", "angles turned by -90 deg", angleTimes(1.0, pusht::kPi / 2)));
  faults.push_back(ofObservation("the tee relative to the pusher",
                                 "the tee's position on the table, as it comes relative to the pusher",
                                 [](Observation& o) {
                                   o[2] -= o[0];
                                   o[3] -= o[1];
                                 }));
  faults.push_back(ofObservation("the table turned", "the table turned by -90 deg", [](Observation& o) {
    for (const std::size_t i : {0, 2, 6}) {
      o[i] = -std::exchange(o[i + 1], o[i]);
    }
    angleTimes(1.0, pusht::kPi / 2)(o);
  }));
}

/// Bounds of the columns of `trained_on`, with a range of 1 where one does not change.
struct Ranges {
  explicit Ranges(const std::vector<Demonstration>& trained_on) {
    least.fill(1e9F);
    range.fill(-1e9F);
    for (const Demonstration& demonstration : trained_on) {
      for (const Observation& o : demonstration.observations) {
        for (std::size_t i = 0; i < o.size(); ++i) {
          least[i] = std::min(least[i], o[i]);
          range[i] = std::max(range[i], o[i]);
        }
      }
    }
    for (std::size_t i = 0; i < range.size(); ++i) {
      range[i] = range[i] - least[i] < 1e-4F ? 1.0F : range[i] - least[i];
    }
  }
  Observation least{};
  Observation range{};
};

void addOfNormalization(std::vector<PolicyFault>& faults, const std::vector<Demonstration>& trained_on) {
  const Ranges ranges(trained_on);
  faults.push_back(ofObservation("normalized twice", "one normalization to [-1, 1] taken off", [=](Observation& o) {
    for (std::size_t i = 0; i < o.size(); ++i) {
      o[i] = (o[i] - ranges.least[i]) * 2.0F / ranges.range[i] - 1.0F;
    }
  }));
  faults.push_back(ofObservation("not normalized", "observations normalized to [-1, 1]", [=](Observation& o) {
    for (std::size_t i = 0; i < o.size(); ++i) {
      o[i] = (o[i] + 1.0F) / 2.0F * ranges.range[i] + ranges.least[i];
    }
  }));
}

void addOfActions(std::vector<PolicyFault>& faults) {
  const auto times = [](float x, float y) {
    return [x, y](Action a, const Observation&) -> Action { return {x * a[0], y * a[1]}; };
  };
  faults.push_back(ofAction("sign of actions", "the other sign of actions", times(-1.0F, -1.0F)));
  faults.push_back(ofAction("sign of an action's y", "the other sign of y of actions", times(1.0F, -1.0F)));
  faults.push_back(ofAction("actions halved", "actions times 2", times(0.5F, 0.5F)));
  faults.push_back(ofAction("actions doubled", "actions times 0.5", times(2.0F, 2.0F)));
  faults.push_back(ofAction("actions in mm/s", "actions times 0.001", times(1000.0F, 1000.0F)));
  faults.push_back(ofAction("ways of a step", "actions times 10 (they are ways of a control step, not velocities)",
                            times(0.1F, 0.1F)));
  faults.push_back(
      ofAction("x and y of actions swapped", "x and y of actions swapped", [](Action a, const Observation&) -> Action {
        return {a[1], a[0]};
      }));
  faults.push_back(ofAction("positions to be reached", "actions taken as positions to be reached in a control step",
                            [](Action a, const Observation& o) -> Action {
                              return {o[0] + 0.1F * a[0], o[1] + 0.1F * a[1]};
                            }));
  faults.push_back(ofAction("actions in the tee's axes", "actions turned from the tee's axes into the table's",
                            [](Action a, const Observation& o) -> Action {
                              return {o[5] * a[0] + o[4] * a[1], o[5] * a[1] - o[4] * a[0]};
                            }));
  faults.push_back(ofDelay(1, "actions 1 step earlier (observations or actions come late)"));
  faults.push_back(ofDelay(2, "actions 2 steps earlier (observations or actions come late)"));
}

/// Rows written number by number, as a wrapper does that has its axes in another order.
template <class Row>
std::vector<Row> numberByNumber(const std::vector<Row>& rows) {
  std::vector<Row> result = rows;
  std::size_t flat = 0;
  for (std::size_t number = 0; number < rows.front().size(); ++number) {
    for (const Row& row : rows) {
      result[flat / row.size()][flat % row.size()] = row[number];
      ++flat;
    }
  }
  return result;
}

void addOfSequences(std::vector<PolicyFault>& faults) {
  PolicyFault upside_down{"history upside down", "the newest observation first"};
  upside_down.history = [](Observations past) {
    std::reverse(past.begin(), past.end());
    return past;
  };
  faults.push_back(upside_down);
  PolicyFault layout{"history number by number",
                     "the history observation by observation, as it comes number by number"};
  layout.history = [](const Observations& past) { return numberByNumber(past); };
  faults.push_back(layout);
  PolicyFault backwards{"chunk backwards", "the last action of an answer first"};
  backwards.chunk = [](Actions actions) {
    std::reverse(actions.begin(), actions.end());
    return actions;
  };
  faults.push_back(backwards);
  PolicyFault axes{"chunk axis by axis", "x and y together, as an answer has all x before all y"};
  axes.chunk = [](const Actions& actions) { return numberByNumber(actions); };
  faults.push_back(axes);
}

}  // namespace

std::vector<PolicyFault> plantedPolicyFaults(const std::vector<Demonstration>& trained_on) {
  std::vector<PolicyFault> faults;
  addOfObservations(faults);
  addOfNormalization(faults, trained_on);
  addOfActions(faults);
  addOfSequences(faults);
  return faults;
}

std::unique_ptr<Policy> faulty(Policy& policy, const PolicySignature& signature,
                               const std::vector<PolicyFault>& faults) {
  return std::make_unique<FaultyPolicy>(policy, signature, faults);
}

}  // namespace sim2sim::testing
