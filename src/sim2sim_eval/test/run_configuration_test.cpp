// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/run_configuration.hpp"

#include <gmock/gmock.h>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"
#include "sim2sim_eval/batch/simulators.hpp"

namespace sim2sim {
namespace {

using ::testing::ElementsAre;

RunConfiguration course(const std::vector<std::string>& engine_settings = {}) {
  RunConfiguration configuration;
  configuration.reference = LoadedSimulator(chooseSimulator("mujoco", {})).record();
  configuration.engine = LoadedSimulator(chooseSimulator("two_mass", engine_settings)).record();
  return configuration;
}

std::string hashOf(const std::string& key) { return pusht::md5(key).substr(0, 12); }

TEST(ConfigurationHash, IsTheCourses) {
  EXPECT_EQ(configurationHash(course()), "4d20147498c1");
  EXPECT_EQ(configurationHash(course({"block_damp=20"})), hashOf("50|4.0|20.0|40.0|300"));
  RunConfiguration smoke = course();
  smoke.smoke = true;
  smoke.protocol = smokeRun(smoke.protocol);
  EXPECT_EQ(configurationHash(smoke), "636a7da5cf2c");
}

TEST(ConfigurationHash, TakesInWhatIsNotAsInTheCourse) {
  RunConfiguration swapped = course({"baumgarte=50"});
  std::swap(swapped.reference, swapped.engine);
  EXPECT_EQ(configurationHash(swapped), hashOf("50|300|reference=two_mass|reference.baumgarte=50.0|engine=mujoco"));

  RunConfiguration mine = course();
  mine.engine = {
      "mine", "my own", {{"stiffness", 2.0}, {"walls", true}, {"shape", "boxes"}}, {}, {"stiffness", "walls"}};
  EXPECT_EQ(configurationHash(mine), hashOf("50|300|engine=mine|engine.stiffness=2.0|engine.walls=True"));
}

TEST(SimulatorRecords, NameFilesByTheirContent) {
  SimulatorRecord record{"mujoco", "MuJoCo"};
  const nlohmann::json provenance = {{"scene", {{"file", "/a/b.xml"}, {"sha256", "abc"}}}};
  record.add("scene", std::string("b.xml"), "", false, provenance);
  record.add("sweeps", std::int64_t{20}, "", true, provenance);
  EXPECT_EQ(record.parameters.dump(), R"({"scene":"sha256:abc","sweeps":20})");
  EXPECT_THAT(record.changed, ElementsAre("scene"));
}

TEST(Configuration, IsReadAsItIsDescribed) {
  RunConfiguration configuration = course();
  configuration.protocol = {~0ULL - 20'000, 3, 7, 123};
  configuration.smoke = true;
  configuration.policy = "some/policy.pt";
  configuration.engine = {
      "mine", "my own", {{"stiffness", 0.1}, {"contact", "boxes"}, {"alpha", 1e-320}}, {"alpha", "contact"}};
  const nlohmann::ordered_json description = describe(configuration);
  const auto read = configurationFrom(nlohmann::ordered_json::parse(description.dump()));
  EXPECT_EQ(describe(read).dump(), description.dump());

  for (const auto& [key, value] : description.items()) {
    nlohmann::ordered_json bad = description;
    bad.erase(key);
    EXPECT_THROW(configurationFrom(bad), pusht::InvalidInput) << "without " << key;
  }
  nlohmann::ordered_json bad = description;
  bad["simulators"]["engine"]["parameters"]["alpha"] = 0.2;
  EXPECT_THROW(configurationFrom(bad), pusht::InvalidInput) << "the hash is of another value";
  bad = description;
  bad["simulators"]["engine"]["changed"].push_back("none");
  EXPECT_THROW(configurationFrom(bad), pusht::InvalidInput) << "there is no such parameter";
}

/// Bags and sweeps of before have other quantities, and must not be read as if they had these. Those of pushes came
/// into runs with state-reset replays alone, whose rows of before are refused for their columns.
TEST(Configuration, FormatIsRaisedWithTheQuantities) {
  const auto columns_of = [](const std::vector<int>& reanchor) {
    Protocol protocol;
    protocol.reanchor = reanchor;
    std::string columns;
    for (const std::size_t i : protocol.quantityColumns()) {
      columns.append(kQuantities[i].name).append(" ").append(kQuantities[i].unit).append("\n");
    }
    return pusht::md5(columns) + " in format " + describe(course()).at("format").dump();
  };
  const char* const advice = "raise the format of metrics in result_files.json, then pin all here";
  EXPECT_EQ(columns_of({}), "c5f2f499b913de2f8ffc12bfcd3ac2d2 in format 6") << advice;
  EXPECT_EQ(columns_of({5}), "a916a1ace853418023a6876db5d3964d in format 6") << advice;
}

TEST(Configuration, OfAnotherFormatIsRefusedByName) {
  nlohmann::ordered_json old = describe(course());
  const std::string now = old["format"].dump();
  old.erase("format");
  try {
    configurationFrom(old);
    FAIL() << "not refused";
  } catch (const pusht::InvalidInput& refusal) {
    EXPECT_EQ(refusal.what(), "format 1: must be " + now + "; another version of the suite wrote it");
  }
}

}  // namespace
}  // namespace sim2sim
