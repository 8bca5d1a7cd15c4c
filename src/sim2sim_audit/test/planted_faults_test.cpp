// SPDX-License-Identifier: BSD-3-Clause
// Whether an audit tells the truth: faults are planted in worlds of three kinds, and it must name them; where there is
// none, it must find none.
#include "planted_faults.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "chipmunk_kind.hpp"
#include "pusht_engine/rigid_body_kind.hpp"
#include "pusht_engine/two_mass_kind.hpp"
#include "pusht_mujoco/mujoco_kind.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/split.hpp"
#include "pusht_testing/long_tests.hpp"
#include "sim2sim_audit/audit.hpp"

namespace sim2sim::testing {
namespace {

/// World of a kind with settings such as "timestep=0.005:cone=elliptic".
WorldFactory worldOf(const pusht::SimulatorKind& kind, const std::string& settings = "") {
  pusht::ParameterSet parameters = kind.defaults();
  for (const std::string& setting : settings.empty() ? std::vector<std::string>() : pusht::split(settings, ':')) {
    const std::size_t equals = setting.find('=');
    parameters.set(setting.substr(0, equals), setting.substr(equals + 1));
  }
  return kind.load(parameters).make_world;
}

/// A kind without a fault and its model variants, measured once.
struct Clean {
  explicit Clean(const pusht::SimulatorKind& kind, std::uint64_t seed = 0)
      : measurements(measured(worldOf(kind), seed)) {
    for (const std::string& variant : kind.variants) {
      variants.push_back(measured(worldOf(kind, variant), seed));
    }
  }

  Audit against(const Measurements& engine) const {
    constexpr double kStartTolerance = 1e-12;  // of all three kinds
    return compare(measurements, engine, variants, kStartTolerance);
  }

  Measurements measurements;
  std::vector<Measurements> variants;
};

std::vector<std::string> keysOf(const std::vector<Comparison>& findings) {
  std::vector<std::string> keys;
  keys.reserve(findings.size());
  for (const Comparison& finding : findings) {
    keys.emplace_back(describe(finding.property).key);
  }
  return keys;
}

std::vector<std::string> keysOf(const std::vector<Property>& properties) {
  std::vector<std::string> keys;
  keys.reserve(properties.size());
  for (const Property property : properties) {
    keys.emplace_back(describe(property).key);
  }
  return keys;
}

/// What an audit made of a fault.
enum class Outcome { kFirst, kLater, kMissed };

Outcome outcomeOf(const PlantedFault& fault, const std::vector<Comparison>& findings) {
  const auto is_name = [&](const Comparison& finding) {
    return std::count(fault.named_by.begin(), fault.named_by.end(), finding.property) > 0;
  };
  const auto found = std::find_if(findings.begin(), findings.end(), is_name);
  if (found == findings.end()) {
    return Outcome::kMissed;
  }
  return found == findings.begin() ? Outcome::kFirst : Outcome::kLater;
}

/// Cell of the table: "first of 2", "after delay", "missed: hold stale_steps".
std::string cellOf(const PlantedFault& fault, const std::vector<Comparison>& findings) {
  const std::vector<std::string> keys = keysOf(findings);
  switch (outcomeOf(fault, findings)) {
    case Outcome::kFirst:
      return "first of " + std::to_string(keys.size());
    case Outcome::kLater:
      return "after " + keys.front();
    case Outcome::kMissed:
      break;
  }
  return "missed: " + pusht::joined(keys, " ");
}

/// The table of test/data/planted_faults.csv, and how often what happened.
struct Table {
  std::string text;
  int planted = 0;
  int first = 0;
  int missed = 0;
};

using WorldOfEachKind = std::array<const WorldFactory*, 3>;

std::array<Clean, 3> cleanKinds() {
  return {Clean(pusht::mujocoKind()), Clean(pusht::chipmunkKind()), Clean(pusht::rigidBodyKind())};
}

/// Worlds with the fault, in the order of cleanKinds(); empty where it cannot be planted.
WorldOfEachKind worldsWith(const PlantedFault& fault) {
  return {&fault.in_mujoco, &fault.in_chipmunk, &fault.in_rigid_body};
}

/// Beginning of the fault's row.
std::string headingOf(const PlantedFault& fault) {
  return "\"" + fault.name + "\",\"" + pusht::joined(keysOf(fault.named_by)) + "\"";
}

Table tableOfFaults() {
  const std::array<Clean, 3> clean = cleanKinds();
  Table table;
  table.text = "fault,named by,in MuJoCo,in Chipmunk,in the rigid body\n";
  for (const PlantedFault& fault : plantedFaults()) {
    table.text += headingOf(fault);
    const WorldOfEachKind makers = worldsWith(fault);
    for (std::size_t kind = 0; kind < makers.size(); ++kind) {
      if (!*makers[kind]) {
        table.text += ",-";
        continue;
      }
      const std::vector<Comparison> findings = clean[kind].against(measured(*makers[kind])).findings();
      table.text += "," + cellOf(fault, findings);
      const Outcome outcome = outcomeOf(fault, findings);
      ++table.planted;
      table.first += outcome == Outcome::kFirst ? 1 : 0;
      table.missed += outcome == Outcome::kMissed ? 1 : 0;
    }
    table.text += "\n";
  }
  return table;
}

std::string expectedTable() {
  std::ifstream file(PLANTED_FAULTS);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Cells of the fault's row in the expected table, one for each kind.
std::vector<std::string> expectedCells(const PlantedFault& fault) {
  const std::string table = expectedTable();
  const std::string heading = headingOf(fault) + ",";
  const std::size_t row = table.find(heading);
  if (row == std::string::npos) {
    return {};
  }
  const std::size_t begin = row + heading.size();
  return pusht::split(table.substr(begin, table.find('\n', begin) - begin), ',');
}

/// The short form: each fault in one kind, as the table has it.
TEST(PlantedFaults, AreNamedInOneKindEach) {
  EXPECT_GE(plantedFaults().size(), 30U);
  const std::array<Clean, 3> clean = cleanKinds();
  std::size_t kind = 0;
  for (const PlantedFault& fault : plantedFaults()) {
    const WorldOfEachKind makers = worldsWith(fault);
    do {
      kind = (kind + 1) % makers.size();
    } while (!*makers[kind]);
    const std::vector<Comparison> findings = clean[kind].against(measured(*makers[kind])).findings();
    EXPECT_NE(outcomeOf(fault, findings), Outcome::kMissed) << fault.name;
    const std::vector<std::string> cells = expectedCells(fault);
    ASSERT_EQ(cells.size(), makers.size()) << fault.name << ": must have a row in " << PLANTED_FAULTS;
    EXPECT_EQ(cells[kind], cellOf(fault, findings)) << fault.name << ", kind " << kind;
  }
}

TEST(PlantedFaults, AreNamed) {
  if (!pusht::testing::longTests()) {
    GTEST_SKIP() << "long form: script/test --long";
  }
  const Table table = tableOfFaults();
  EXPECT_EQ(table.missed, 0) << table.text;
  EXPECT_GE(table.first, 0.95 * table.planted) << table.text;
  EXPECT_EQ(expectedTable(), table.text) << PLANTED_FAULTS;
}

/// Pairs that are the same, over seeds.
class SamePair : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(SamePair, EachKindAndItself) {
  for (const pusht::SimulatorKind* kind :
       {&pusht::mujocoKind(), &pusht::chipmunkKind(), &pusht::rigidBodyKind(), &pusht::twoMassKind()}) {
    const Clean clean(*kind, GetParam());
    EXPECT_THAT(keysOf(clean.against(measured(worldOf(*kind), GetParam())).findings()), ::testing::IsEmpty())
        << kind->name;
  }
}

TEST_P(SamePair, MujocoAndTheFaithfulRigidBody) {
  const Clean clean(pusht::mujocoKind(), GetParam());
  EXPECT_THAT(keysOf(clean.against(measured(worldOf(pusht::rigidBodyKind()), GetParam())).findings()),
              ::testing::IsEmpty());
}

/// Each model variant is the same within the others: its physics is MuJoCo's, by other numerics. Euler's servo is
/// explicit.
TEST_P(SamePair, MujocoAndItsModelVariants) {
  const Clean clean(pusht::mujocoKind(), GetParam());
  for (std::size_t i = 0; i < clean.variants.size(); ++i) {
    Clean without = clean;
    without.variants.erase(without.variants.begin() + static_cast<std::ptrdiff_t>(i));
    const std::string& variant = pusht::mujocoKind().variants[i];
    const std::vector<std::string> expected(variant == "integrator=Euler" ? 1 : 0, "servo_lag");
    EXPECT_EQ(keysOf(without.against(clean.variants[i]).findings()), expected) << variant;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, SamePair,
                         ::testing::Range(std::uint64_t{0}, std::uint64_t{pusht::testing::longTests() ? 20U : 2U}));

/// A seed moves every scene; 1e-6 m is less than that.
TEST(SamePairs, StartsThatAreNudged) {
  const Clean clean(pusht::mujocoKind());
  EXPECT_THAT(keysOf(clean.against(measured(worldOf(pusht::mujocoKind()), 1)).findings()), ::testing::IsEmpty());
}

/// What the ladder knows of the two-mass engine is found unaided.
TEST(TwoMass, DiffersWhereTheLadderSaysSo) {
  const Clean clean(pusht::mujocoKind());
  const std::vector<std::string> keys = keysOf(clean.against(measured(worldOf(pusht::twoMassKind()))).findings());
  for (const char* key :
       {"servo_gain", "servo_limit", "pusher_mass", "tee_moment", "tee_damping", "damping_point", "tee_friction_x",
        "tee_friction_y", "tee_yaw_friction", "contact_friction", "outline", "wall_up"}) {
    EXPECT_THAT(keys, ::testing::Contains(key));
  }
}

/// Chipmunk is the same but for its contacts, as its README says.
TEST(Chipmunk, DiffersInItsContacts) {
  const Clean clean(pusht::mujocoKind());
  EXPECT_THAT(keysOf(clean.against(measured(worldOf(pusht::chipmunkKind()))).findings()),
              ::testing::ElementsAre("overlap"));
}

}  // namespace
}  // namespace sim2sim::testing
