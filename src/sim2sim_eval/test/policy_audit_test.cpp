// SPDX-License-Identifier: BSD-3-Clause
// Whether an audit of a policy tells the truth: faults are planted in the shipped policies, and it must name them;
// where there is none, it must find none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "planted_policy_faults.hpp"
#include "pusht_engine/two_mass_kind.hpp"
#include "pusht_mujoco/mujoco_kind.hpp"
#include "pusht_policy/policy_choice.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/constants.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/rollout.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "pusht_testing/long_tests.hpp"
#include "sim2sim_eval/policy_audit_run.hpp"
#include "sim2sim_serving/installed_file.hpp"

namespace sim2sim::testing {
namespace {

/// Demonstrations of a policy in a kind of simulator, from spawn seeds on.
std::vector<Demonstration> demonstrationsOf(pusht::Policy& policy, const pusht::SimulatorKind& kind, std::uint64_t seed,
                                            int episodes) {
  const std::unique_ptr<pusht::Simulator> world = kind.load(kind.defaults()).make_world();
  std::vector<Demonstration> demonstrations;
  for (int i = 0; i < episodes; ++i) {
    const pusht::WorldState start = pusht::spawn(seed + static_cast<std::uint64_t>(i));
    const pusht::Rollout rollout = pusht::runClosedLoop(*world, start, policy, pusht::kHorizon);
    const pusht::Trace& trace = rollout.trace();
    demonstrations.emplace_back();
    for (std::size_t step = 0; step < trace.steps(); ++step) {
      demonstrations.back().observations.push_back(pusht::observe(trace.states[step]));
      demonstrations.back().actions.push_back(trace.actions[step]);
    }
  }
  return demonstrations;
}

std::vector<Demonstration> demonstrationsOfTheExpert(std::uint64_t seed, int episodes) {
  pusht::ScriptedExpert expert;
  return demonstrationsOf(expert, pusht::mujocoKind(), seed, episodes);
}

const std::vector<Demonstration>& heldDemonstrations() {
  static const std::vector<Demonstration> demonstrations = demonstrationsOfTheExpert(20'000, 40);
  return demonstrations;
}

/// Demonstrations that a wrapper takes its normalization from.
const std::vector<Demonstration>& otherDemonstrations() {
  static const std::vector<Demonstration> demonstrations = demonstrationsOfTheExpert(500, 60);
  return demonstrations;
}

/// A policy of the suite, as one of a kind.
struct Shipped {
  std::string kind;
  std::string policy;  ///< a name, or a file of pusht_policy
  int actions = 0;     ///< of an answer that are used; 0: all
};

const std::vector<Shipped>& shippedPolicies() {
  static const std::vector<Shipped> policies = {
      {"expert", pusht::kExpertPolicy},   {"plain", "policies/bc_policy.ts.pt"}, {"history", "policies/chunk.ts.pt", 1},
      {"chunks", "policies/chunk.ts.pt"}, {"state", "policies/gru.ts.pt"},       {"noise", "policies/flow.ts.pt"}};
  return policies;
}

/// A loaded policy with its signature.
struct Loaded {
  explicit Loaded(const Shipped& shipped) {
    const bool is_file = shipped.policy != pusht::kExpertPolicy;
    const std::string name = is_file ? pusht::installedFile("pusht_policy", shipped.policy).string() : shipped.policy;
    const pusht::ChosenPolicy chosen = pusht::choosePolicy({name, true}, name);
    signature = signatureOf(chosen);
    signature.actions = shipped.actions > 0 ? shipped.actions : signature.actions;
    policy = chosen.make();
  }

  PolicyAudit audit(const std::vector<Demonstration>& demonstrations = heldDemonstrations()) const {
    return auditPolicy(*policy, signature, demonstrations);
  }

  /// A policy without a memory that is late has one.
  PolicyAudit auditWith(const std::vector<PolicyFault>& faults) const {
    PolicySignature asked = signature;
    const bool is_late =
        std::any_of(faults.begin(), faults.end(), [](const PolicyFault& fault) { return fault.delay > 0; });
    asked.has_state = asked.has_state || (is_late && signature.isPlain());
    return auditPolicy(*faulty(*policy, signature, faults), asked, heldDemonstrations());
  }

  bool takes(const std::vector<PolicyFault>& faults) const {
    return std::all_of(faults.begin(), faults.end(), [&](const PolicyFault& fault) { return fault.fits(signature); });
  }

  PolicySignature signature;
  std::unique_ptr<pusht::Policy> policy;
};

using Faults = std::vector<PolicyFault>;

/// Single faults, and two at once.
std::vector<Faults> plantedFaults() {
  const std::vector<PolicyFault> singles = plantedPolicyFaults(otherDemonstrations());
  const auto named = [&](const std::string& name) {
    return *std::find_if(singles.begin(), singles.end(), [&](const PolicyFault& fault) { return fault.name == name; });
  };
  std::vector<Faults> planted;
  std::transform(singles.begin(), singles.end(), std::back_inserter(planted),
                 [](const PolicyFault& fault) { return Faults{fault}; });
  for (const auto& [one, other] :
       std::vector<std::pair<std::string, std::string>>{{"pusher and tee swapped", "actions halved"},
                                                        {"sine and cosine swapped", "sign of an action's y"},
                                                        {"positions in mm", "actions 1 control steps late"},
                                                        {"normalized twice", "sign of actions"},
                                                        {"pusher and tee swapped", "positions halved"},
                                                        {"pusher and tee swapped", "sine and cosine swapped"},
                                                        {"x and y of actions swapped", "actions doubled"},
                                                        {"history upside down", "sign of actions"},
                                                        {"chunk backwards", "pusher and tee swapped"}}) {
    planted.push_back({named(one), named(other)});
  }
  return planted;
}

std::string nameOf(const Faults& faults) {
  std::vector<std::string> parts;
  for (const PolicyFault& fault : faults) {
    parts.push_back(fault.name);
  }
  return pusht::joined(parts, " and ");
}

/// Whether an explanation has a correction of each fault, and no other.
bool isOf(const Explanation& explanation, const Faults& faults) {
  return explanation.corrections.size() == faults.size() &&
         std::all_of(faults.begin(), faults.end(), [&](const PolicyFault& fault) {
           return std::any_of(explanation.corrections.begin(), explanation.corrections.end(),
                              [&](const std::string& words) { return words.rfind(fault.named_by, 0) == 0; });
         });
}

/// Cell of the table: "named", "beside 1 other", "missed: near".
std::string cellOf(const PolicyAudit& audit, const Faults& faults) {
  const auto& all = audit.explanations;
  const auto is_named = [](const Explanation& explanation) { return explanation.is_named; };
  const bool is_right = std::any_of(all.begin(), all.end(), [&](const Explanation& explanation) {
    return explanation.is_named && isOf(explanation, faults);
  });
  const auto named = std::count_if(all.begin(), all.end(), is_named);
  if (!is_right) {
    return "missed: " + std::string(sim2sim::nameOf(audit.verdict));
  }
  return named == 1 ? "named" : "beside " + std::to_string(named - 1);
}

std::string rowOf(const std::string& kind, const Faults& faults, const std::string& cell) {
  return kind + ",\"" + nameOf(faults) + "\"," + cell + "\n";
}

/// Rows of test/data/planted_policy_faults.csv that begin so.
std::string expectedRows(const std::string& beginning) {
  std::ifstream file(PLANTED_POLICY_FAULTS);
  std::string rows;
  for (std::string row; std::getline(file, row);) {
    rows += row.rfind(beginning, 0) == 0 ? row + "\n" : "";
  }
  return rows;
}

const Shipped& shippedOf(const std::string& kind) {
  const auto& all = shippedPolicies();
  return *std::find_if(all.begin(), all.end(), [&](const Shipped& shipped) { return shipped.kind == kind; });
}

/// The short form: some faults of each sort, in policies that are fast.
TEST(PlantedPolicyFaults, SomeAreNamedInSomeKinds) {
  const std::map<std::string, std::set<std::string>> some = {
      {"expert",
       {"pusher and tee swapped", "sign of the sine", "positions in mm", "origin in a corner",
        "trained with a yaw taken for degrees", "the tee relative to the pusher", "positions to be reached",
        "actions in the tee's axes", "pusher and tee swapped and positions halved"}},
      {"history", {"history upside down", "not normalized", "pusher and tee swapped and actions halved"}},
      {"chunks", {"chunk backwards", "actions 1 control steps late"}}};
  for (const auto& [kind, names] : some) {
    const Loaded loaded(shippedOf(kind));
    std::size_t planted = 0;
    for (const Faults& faults : plantedFaults()) {
      if (names.count(nameOf(faults)) > 0) {
        ++planted;
        const std::string row = rowOf(kind, faults, cellOf(loaded.auditWith(faults), faults));
        EXPECT_EQ(expectedRows(row.substr(0, row.rfind(',') + 1)), row);
      }
    }
    EXPECT_EQ(planted, names.size()) << kind;
  }
}

class PlantedInEachKind : public ::testing::TestWithParam<std::string> {};

TEST_P(PlantedInEachKind, AreNamed) {
  if (!pusht::testing::longTests()) {
    GTEST_SKIP() << "long form: script/test --long";
  }
  const Loaded loaded(shippedOf(GetParam()));
  std::string rows;
  int named = 0;
  for (const Faults& faults : plantedFaults()) {
    if (loaded.takes(faults)) {
      const std::string cell = cellOf(loaded.auditWith(faults), faults);
      named += cell.rfind("missed", 0) != 0 ? 1 : 0;
      rows += rowOf(GetParam(), faults, cell);
    }
  }
  EXPECT_GE(named, 20);
  EXPECT_EQ(expectedRows(GetParam() + ","), rows) << PLANTED_POLICY_FAULTS;
}

INSTANTIATE_TEST_SUITE_P(PlantedPolicyFaults, PlantedInEachKind,
                         ::testing::Values("expert", "plain", "history", "chunks", "state", "noise"));

/// Demonstrations that a policy was not trained on: of another demonstrator, in another simulator.
std::vector<std::vector<Demonstration>> strangeDemonstrations() {
  constexpr int kEpisodes = 40;
  constexpr std::uint64_t kSeed = 30'000;
  pusht::ScriptedExpert expert;
  std::vector<std::vector<Demonstration>> all = {demonstrationsOf(expert, pusht::twoMassKind(), kSeed, kEpisodes)};
  for (const char* kind : {"plain", "chunks", "state"}) {
    const Loaded demonstrator(shippedOf(kind));
    all.push_back(demonstrationsOf(*demonstrator.policy, pusht::mujocoKind(), kSeed, kEpisodes));
  }
  return all;
}

TEST(SoundPolicies, RaiseNoFault) {
  for (const Shipped& shipped : shippedPolicies()) {
    if (pusht::testing::longTests() || shipped.kind == "expert" || shipped.kind == "history") {
      const PolicyAudit audit = Loaded(shipped).audit();
      EXPECT_EQ(audit.verdict, PolicyVerdict::kNear) << textOf(audit, shipped.kind, "the expert's demonstrations");
    }
  }
}

TEST(SoundPolicies, RaiseNoFaultWithDemonstrationsOfOthers) {
  if (!pusht::testing::longTests()) {
    GTEST_SKIP() << "long form: script/test --long";
  }
  const std::vector<std::vector<Demonstration>> strange = strangeDemonstrations();
  for (const Shipped& shipped : shippedPolicies()) {
    const Loaded loaded(shipped);
    for (const std::vector<Demonstration>& demonstrations : strange) {
      const PolicyAudit audit = loaded.audit(demonstrations);
      EXPECT_NE(audit.verdict, PolicyVerdict::kFault) << textOf(audit, shipped.kind, "demonstrations of another");
    }
  }
}

/// Policy that draws any of the demonstrated actions, whatever it sees.
class Unseeing final : public pusht::Policy {
 public:
  struct Draws : Memory {
    explicit Draws(std::uint64_t seed) : random(seed) {}
    pusht::NumpyGenerator random;
  };

  std::unique_ptr<Memory> begin(const pusht::Beginning& beginning) const override {
    return std::make_unique<Draws>(beginning.seed);
  }
  void act(pusht::Span<const Query> queries, pusht::Span<pusht::Action> actions) override {
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const auto& recorded = otherDemonstrations()[i % otherDemonstrations().size()].actions;
      const double random = static_cast<Draws*>(queries[i].memory)->random.random();
      actions[i] = recorded[static_cast<std::size_t>(random * static_cast<double>(recorded.size()))];
    }
  }
};

/// It is scored as what it is: no better than any action.
TEST(PolicyAudit, APolicyThatDoesNotLookIsFar) {
  Unseeing policy;
  PolicySignature signature;
  signature.is_stochastic = true;
  const PolicyAudit audit = auditPolicy(policy, signature, heldDemonstrations());
  EXPECT_EQ(audit.verdict, PolicyVerdict::kUnexplained) << textOf(audit, "unseeing", "the expert's");
  EXPECT_NEAR(audit.error.value, audit.constant.value, 0.1 * audit.constant.value);
}

/// Policy that answers NaN to its hundredth observation.
class Endless final : public pusht::Policy {
 public:
  void act(pusht::Span<const Query> queries, pusht::Span<pusht::Action> actions) override {
    for (pusht::Action& action : actions) {
      action = {0.0F, ++asked_ == kBad ? std::numeric_limits<float>::quiet_NaN() : 0.0F};
    }
    (void)queries;
  }

 private:
  static constexpr int kBad = 100;
  int asked_ = 0;
};

TEST(PolicyAudit, AnAnswerThatIsNotFiniteIsRefused) {
  Endless policy;
  EXPECT_THROW(auditPolicy(policy, {}, heldDemonstrations()), pusht::BadDependency);
}

/// Demonstrations that are one episode are cut into parts.
TEST(PolicyAudit, TakesOneLongEpisode) {
  std::vector<Demonstration> one(1);
  for (const Demonstration& demonstration : heldDemonstrations()) {
    one[0].observations.insert(one[0].observations.end(), demonstration.observations.begin(),
                               demonstration.observations.end());
    one[0].actions.insert(one[0].actions.end(), demonstration.actions.begin(), demonstration.actions.end());
  }
  const Loaded history(shippedOf("history"));
  const Faults faults = {plantedPolicyFaults(otherDemonstrations()).front()};
  const PolicyAudit audit = auditPolicy(*faulty(*history.policy, history.signature, faults), history.signature, one);
  EXPECT_FALSE(audit.are_episodes);
  EXPECT_EQ(cellOf(audit, faults), "named") << textOf(audit, "", "");
}

}  // namespace
}  // namespace sim2sim::testing
