// SPDX-License-Identifier: BSD-3-Clause
#include "parameter_group.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "parameters.hpp"

namespace pusht_rviz {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

pusht_msgs::ParameterDescriptor descriptor(const std::string& name, const std::string& type,
                                           const std::string& default_value, double least = -kUnbounded,
                                           double greatest = kUnbounded) {
  pusht_msgs::ParameterDescriptor made;
  made.name = name;
  made.type = type;
  made.default_value = default_value;
  made.least = least;
  made.greatest = greatest;
  return made;
}

pusht_msgs::ParameterDescriptor blockDamp() {
  pusht_msgs::ParameterDescriptor made = descriptor("block_damp", "real", "6.0", 0.0, 100.0);
  made.unit = "1/s";
  return made;
}

pusht_msgs::Preset preset(const std::string& word, const std::string& servo, const std::string& walls) {
  pusht_msgs::Preset made;
  made.word = word;
  made.settings = {parameter("servo", servo), parameter("walls", walls)};
  return made;
}

pusht_msgs::ParameterDescriptor presets() {
  pusht_msgs::ParameterDescriptor made = descriptor("preset", "text", "faithful");
  made.words = {"faithful", "shaped", "simple"};
  made.presets = {preset("faithful", "true", "true"), preset("shaped", "true", "false"),
                  preset("simple", "false", "false")};
  return made;
}

/// Description of an engine with two switches, which a word sets; the node is simple.
pusht_msgs::DescribeResponse rigidBody() {
  pusht_msgs::DescribeResponse made;
  made.parameter_descriptors = {presets(), descriptor("servo", "boolean", "true"),
                                descriptor("walls", "boolean", "true")};
  made.parameters = {parameter("preset", "simple"), parameter("servo", "false"), parameter("walls", "false")};
  return made;
}

/// Description of an engine with two parameters; the node has a block_damp of 20.
pusht_msgs::DescribeResponse twoMassNode() {
  pusht_msgs::DescribeResponse made;
  made.parameter_descriptors = {descriptor("pusher_mass", "real", "4.0", 0.1, 100.0), blockDamp()};
  made.parameters = {parameter("pusher_mass", "4.0"), parameter("block_damp", "20.0")};
  return made;
}

TEST(Rules, AreThoseOfTheTask) {
  EXPECT_EQ(refusalOf(blockDamp(), "0"), "");
  EXPECT_EQ(refusalOf(blockDamp(), "100.0"), "");
  EXPECT_EQ(refusalOf(blockDamp(), "1e9"), "block_damp 1000000000.0: must be from 0.0 to 100.0 [1/s]");
  for (const char* const text : {"6,0", "nan", ""}) {
    EXPECT_EQ(refusalOf(blockDamp(), text), "block_damp '" + std::string(text) + "': must be a decimal number");
  }
  const auto iterations = descriptor("iterations", "integer", "30", 1, 1000);
  EXPECT_EQ(refusalOf(iterations, "1000"), "");
  EXPECT_EQ(refusalOf(iterations, "1001"), "iterations 1001: must be from 1 to 1000");
  EXPECT_EQ(refusalOf(iterations, "1.0"), "iterations '1.0': must be a decimal integer");
  EXPECT_EQ(refusalOf(descriptor("on", "boolean", "true"), "yes"), "on 'yes': must be true or false");
  EXPECT_EQ(refusalOf(descriptor("on", "boolean", "true"), "false"), "");
  EXPECT_EQ(refusalOf(presets(), "shaped"), "");
  EXPECT_EQ(refusalOf(presets(), "ideal"), "preset 'ideal': must be one of: faithful, shaped, simple");
  EXPECT_EQ(refusalOf(descriptor("scene", "text", ""), "any thing"), "");
  EXPECT_EQ(rangeOf(blockDamp()), "from 0.0 to 100.0 [1/s]");
}

TEST(Rules, LetSeedsBeBeyondTheIntegersOfParameters) {
  const auto seed = descriptor("seed", "integer", "0", 0.0);
  EXPECT_EQ(refusalOf(seed, "18446744073709551615"), "");
  EXPECT_NE(refusalOf(seed, "18446744073709551616"), "");
  EXPECT_EQ(refusalOf(seed, "-1"), "seed -1: must be at least 0");
  EXPECT_NE(refusalOf(descriptor("count", "integer", "0", 0.0, 10.0), "18446744073709551615"), "");
}

/// Group whose rows are edited by their names.
class Group : public ParameterGroup {
 public:
  template <class... Description>
  explicit Group(const Description&... description) : ParameterGroup("engine", nullptr) {
    build(description...);
  }
  void type(const char* name, const char* text) { find(name)->setText(text); }

  /// Texts of the simulator's parameters, without those of the loop.
  std::vector<std::string> texts() const {
    std::vector<std::string> texts;
    for (const ParameterProperty* const row : parameters()) {
      if (row->descriptor().name.rfind("loop.", 0) != 0) {
        texts.push_back(row->text());
      }
    }
    return texts;
  }
};

using Chosen = std::vector<pusht_msgs::Parameter>;

TEST(ParameterGroup, NamesWhatDiffersFromTheDefaultsOfTheKind) {
  EXPECT_THAT(Group(twoMassNode(), Chosen{}).named(), IsEmpty())
      << "what the node is does not count: its kind is named";
  Group group(twoMassNode(), Chosen{parameter("block_damp", "20"), parameter("no_such", "1")});
  EXPECT_THAT(group.named(), ElementsAre(parameter("block_damp", "20")));
  group.type("block_damp", "6");
  EXPECT_THAT(group.named(), IsEmpty()) << "6 is 6.0";
}

TEST(ParameterGroup, AlwaysNamesParametersWhoseDefaultIsNotKnown) {
  pusht_msgs::DescribeResponse foreign;
  foreign.parameters = {parameter("gain", "3")};
  Group group(foreign, Chosen{});
  EXPECT_THAT(group.named(), ElementsAre(parameter("gain", "3")));
  group.type("gain", "whatever");
  EXPECT_THAT(group.named(), ElementsAre(parameter("gain", "whatever")));
}

TEST(ParameterGroup, NamesOptionsThatDifferFromTheEvaluatorsValues) {
  pusht_msgs::RunOptions options;
  options.descriptors = {descriptor("seed", "integer", "0", 0.0), descriptor("floor", "boolean", "true")};
  options.values = {parameter("seed", "9223372036854775809"), parameter("floor", "false")};
  Group group(options);
  EXPECT_THAT(group.named(), IsEmpty()) << "whatever the defaults";
  group.type("seed", "9223372036854775808");
  EXPECT_THAT(group.named(), ElementsAre(parameter("seed", "9223372036854775808"))) << "one double, two seeds";
  group.type("floor", "true");
  EXPECT_THAT(group.named(), ElementsAre(parameter("seed", "9223372036854775808"), parameter("floor", "true")));
}

TEST(ParameterGroup, RefusesByName) {
  Group group(twoMassNode(), Chosen{});
  EXPECT_EQ(group.refusal(), "");
  group.type("block_damp", " 1000 ");
  EXPECT_EQ(group.find("block_damp")->text(), "1000") << "never corrected, but for spaces";
  EXPECT_EQ(group.refusal(), "block_damp 1000.0: must be from 0.0 to 100.0 [1/s]");
}

TEST(Presets, SetWhatDoesNotDifferYet) {
  Group group(rigidBody(), Chosen{});
  EXPECT_THAT(group.texts(), ElementsAre("faithful", "true", "true"));
  group.type("preset", "simple");
  EXPECT_THAT(group.texts(), ElementsAre("simple", "false", "false"));
  EXPECT_THAT(group.named(), ElementsAre(parameter("preset", "simple"))) << "which sets the switches";
  group.type("servo", "true");
  EXPECT_THAT(group.named(), ElementsAre(parameter("preset", "simple"), parameter("servo", "true")))
      << "though that is its default";
  group.type("preset", "shaped");
  EXPECT_THAT(group.texts(), ElementsAre("shaped", "true", "false"));
  EXPECT_THAT(group.named(), ElementsAre(parameter("preset", "shaped")));
  group.type("walls", "true");
  group.type("preset", "faithful");
  EXPECT_THAT(group.texts(), ElementsAre("faithful", "true", "true"));
  EXPECT_THAT(group.named(), IsEmpty());
}

TEST(Presets, LeaveWhatIsChosenByName) {
  const Chosen chosen = {parameter("preset", "simple"), parameter("servo", "true")};
  Group group(rigidBody(), chosen);
  EXPECT_THAT(group.texts(), ElementsAre("simple", "true", "false"));
  EXPECT_EQ(group.named(), chosen);
  EXPECT_THAT(Group(rigidBody(), rigidBody().parameters).named(), ElementsAre(parameter("preset", "simple")));
}

TEST(ParameterGroup, HasTheLoopBesideTheSimulator) {
  Group group(twoMassNode(), Chosen{parameter("loop.hold", "3")});
  EXPECT_THAT(group.named(), ElementsAre(parameter("loop.hold", "3")));
  EXPECT_EQ(group.find("loop.action_delay")->descriptor().unit, "control steps");
  EXPECT_NE(refusalOf(group.find("loop.action_delay")->descriptor(), "-1"), "");
  group.type("loop.action_delay", "2");
  EXPECT_THAT(group.named(), ElementsAre(parameter("loop.action_delay", "2"), parameter("loop.hold", "3")));
}

}  // namespace
}  // namespace pusht_rviz
