// SPDX-License-Identifier: BSD-3-Clause
#include "simulator_property.hpp"

#include <gmock/gmock.h>

#include <string>

#include "parameters.hpp"

namespace pusht_rviz {
namespace {

using ::testing::ElementsAre;

/// What a node says that can be one kind, with a parameter of default 6 and one that has no descriptor.
pusht_msgs::DescribeResponse nodeWith(const std::string& damp, const std::string& gain) {
  pusht_msgs::DescribeResponse made;
  made.success = 1;
  made.name = "springy";
  made.parameters = {parameter("damp", damp), parameter("gain", gain)};
  pusht_msgs::ParameterDescriptor described;
  described.name = "damp";
  described.type = "real";
  described.default_value = "6.0";
  described.least = 0.0;
  described.greatest = 100.0;
  made.parameter_descriptors = {described};
  return made;
}

class SimulatorPropertyTest : public testing::Test {
 protected:
  void type(const char* name, const char* text) { simulator_.find(name)->setText(text); }
  std::string shown(const char* name) { return simulator_.find(name)->text(); }
  bool marked(const char* name) { return simulator_.find(name)->differs(); }

  SimulatorProperty simulator_{"engine", nullptr};
};

TEST_F(SimulatorPropertyTest, SendsWhatItShowsWhateverARunMadeOfTheNode) {
  simulator_.setRequest("", {});
  simulator_.setNode(nodeWith("6.0", "1"));
  type("damp", "20");
  const std::vector<pusht_msgs::Parameter> wanted = {parameter("damp", "20"), parameter("gain", "1")};
  EXPECT_EQ(simulator_.kind(), "springy");
  EXPECT_EQ(simulator_.named(), wanted);
  simulator_.setNode(nodeWith("20.0", "1"));  // after the run
  EXPECT_EQ(shown("damp"), "20");
  EXPECT_EQ(simulator_.named(), wanted) << "a run inherits nothing from the one before";
  type("damp", "6");
  EXPECT_THAT(simulator_.named(), ElementsAre(parameter("gain", "1"))) << "the default of the kind that is named";
}

TEST_F(SimulatorPropertyTest, MarksWhatWasChangedWhateverARunMadeOfTheNode) {
  simulator_.setNode(nodeWith("6.0", "1"));
  EXPECT_FALSE(marked("damp"));
  EXPECT_FALSE(marked("gain"));
  type("damp", "20");
  type("gain", "2");
  for (const auto& node : {nodeWith("6.0", "1"), nodeWith("20.0", "2")}) {
    simulator_.setNode(node);
    EXPECT_TRUE(marked("damp"));
    EXPECT_TRUE(marked("gain"));
  }
}

TEST_F(SimulatorPropertyTest, BeginsWithWhatTheEvaluatorAsksFor) {
  simulator_.setRequest("", {parameter("damp", "8")});
  simulator_.setNode(nodeWith("20.0", "3"));
  EXPECT_THAT(simulator_.named(), ElementsAre(parameter("damp", "8"), parameter("gain", "3")));
  simulator_.setRequest("", {});
  EXPECT_THAT(simulator_.named(), ElementsAre(parameter("damp", "20.0"), parameter("gain", "3")))
      << "else with what the node has";
  simulator_.setRequest("springy", {});
  EXPECT_EQ(shown("damp"), "6.0") << "a kind that is named has its defaults";
}

TEST_F(SimulatorPropertyTest, IsBuiltAnewForAnotherSimulator) {
  simulator_.setNode(nodeWith("6.0", "1"));
  type("damp", "20");
  pusht_msgs::DescribeResponse other = nodeWith("6.0", "1");
  other.name = "stiff";
  simulator_.setNode(other);
  EXPECT_EQ(simulator_.kind(), "stiff");
  EXPECT_EQ(shown("damp"), "6.0");
}

/// Node that can become two kinds.
pusht_msgs::DescribeResponse nodeOfKinds() {
  pusht_msgs::DescribeResponse made = nodeWith("6.0", "1");
  made.kinds = {"springy", "stiff"};
  return made;
}

TEST_F(SimulatorPropertyTest, WaitsForTheDescriptionOfTheKindThatIsChosen) {
  std::vector<QString> needed;
  QObject::connect(&simulator_, &SimulatorProperty::kindNeeded, [&](const QString& kind) { needed.push_back(kind); });
  simulator_.setNode(nodeOfKinds());
  EXPECT_THAT(needed, ElementsAre("springy")) << "what the node is";
  EXPECT_EQ(simulator_.waitsFor(), "engine: waiting for the node to describe springy");
  simulator_.setString("stiff");
  EXPECT_THAT(needed, ElementsAre("springy", "stiff"));
  simulator_.setKind("springy", nodeOfKinds());
  EXPECT_EQ(simulator_.waitsFor(), "engine: waiting for the node to describe stiff") << "an answer that is late";
  simulator_.setKind("stiff", nodeOfKinds());
  EXPECT_EQ(simulator_.waitsFor(), "");
  EXPECT_EQ(simulator_.kind(), "stiff");
  EXPECT_EQ(shown("damp"), "6.0");
}

}  // namespace
}  // namespace pusht_rviz
