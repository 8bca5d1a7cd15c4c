// SPDX-License-Identifier: BSD-3-Clause
#include "bag/messages.hpp"

#include <gmock/gmock.h>

#include "pusht_task/error.hpp"
#include "sim2sim_serving/conversions.hpp"
#include "sim2sim_serving/node_parameters.hpp"

namespace sim2sim {
namespace {

using ::testing::ElementsAre;

pusht_msgs::DescribeResponse nodeDescription(const pusht::Parameters& parameters) {
  pusht_msgs::DescribeResponse description;
  description.name = "mine";
  description.parameters = parameters;
  description.provenance = "{}";
  return description;
}

TEST(RecordOf, GivesParametersTheTypeThatTheirTextShows) {
  const SimulatorRecord record = recordOf(nodeDescription(
      {pusht::parameter("walls", "true"), pusht::parameter("friction", "false"), pusht::parameter("sweeps", "20"),
       pusht::parameter("drag", "20.0"), pusht::parameter("shape", "two discs"), pusht::parameter("limit", "inf"),
       pusht::parameter("code", "010")}));
  EXPECT_EQ(
      record.parameters.dump(),
      R"({"walls":true,"friction":false,"sweeps":20,"drag":20.0,"shape":"two discs","limit":"inf","code":"010"})");
  EXPECT_EQ(record.title, "mine") << "it has no other";
  EXPECT_EQ(record.changed.size(), 7U) << "their defaults are not known";
}

TEST(RecordOf, TakesTypesAndDefaultsFromDescriptors) {
  auto description = nodeDescription({pusht::parameter("shape", "20"), pusht::parameter("drag", "6.0")});
  description.title = "my own";
  for (const auto& [name, type, value] : {std::tuple("shape", "text", "boxes"), std::tuple("drag", "real", "6.0")}) {
    description.parameter_descriptors.emplace_back();
    description.parameter_descriptors.back().name = name;
    description.parameter_descriptors.back().type = type;
    description.parameter_descriptors.back().default_value = value;
  }
  const SimulatorRecord record = recordOf(description);
  EXPECT_EQ(record.title, "my own");
  EXPECT_EQ(record.parameters.dump(), R"({"shape":"20","drag":6.0})");
  EXPECT_THAT(record.changed, ElementsAre("shape"));
}

TEST(ProvenanceOf, HasTheNodesVersionUnlessItSaysOneItself) {
  auto description = nodeDescription({});
  description.version = "1.2";
  description.provenance = "{}";
  EXPECT_EQ(pusht::provenanceOf(description).dump(), R"({"version":"1.2"})");
  description.provenance = R"({"version":"of its own"})";
  EXPECT_EQ(pusht::provenanceOf(description).dump(), R"({"version":"of its own"})");
}

TEST(RecordOf, RefusesAProvenanceThatIsNone) {
  auto description = nodeDescription({});
  description.provenance = "none";
  EXPECT_THROW(recordOf(description), pusht::BadDependency);
}

}  // namespace
}  // namespace sim2sim
