// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/node_parameters.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "pusht_task/error.hpp"
#include "pusht_testing/refusal.hpp"

namespace pusht {
namespace {

using testing::refusalOf;

const ParameterDescriptor kMass = {"mass", "kg", "of the tee", 4.0, 0.0, 10.0, "it is a toy"};

TEST(ParameterDescriptors, ReadDecimalNumbers) {
  EXPECT_EQ(kMass.read("6"), ParameterValue(6.0));
  EXPECT_EQ(kMass.read("0.25"), ParameterValue(0.25));
  EXPECT_EQ(kMass.read("1e-3"), ParameterValue(1e-3));
  EXPECT_FALSE(std::signbit(std::get<double>(kMass.read("-0"))));
}

TEST(ParameterDescriptors, ComeBackFromTheirMessages) {
  ParameterDescriptor mode = {"mode", "", "of the tee", std::string("free")};
  mode.words = {"free", "stuck"};
  mode.presets = {{"stuck", {{"mass", "10.0"}}}};
  for (const ParameterDescriptor& descriptor : {kMass, mode, ParameterDescriptor{"walls", "", "", true}}) {
    const pusht_msgs::ParameterDescriptor message = toMessage(descriptor);
    EXPECT_EQ(toMessage(fromMessage(message)), message);
  }
  pusht_msgs::ParameterDescriptor message = toMessage(kMass);
  message.default_value = "much";
  EXPECT_EQ(refusalOf<BadDependency>([&] { fromMessage(message); }),
            "default of mass 'much': must be a decimal number");
  message.type = "complex";
  EXPECT_EQ(refusalOf<BadDependency>([&] { fromMessage(message); }),
            "parameter mass: type 'complex': must be boolean, integer, real or text");
}

TEST(ParameterDescriptors, ReadWhatTheyAre) {
  EXPECT_EQ(ParameterDescriptor({"walls", "", "", false}).read("true"), ParameterValue(true));
  EXPECT_EQ(ParameterDescriptor({"sweeps", "", "", std::int64_t{1}}).read("20"), ParameterValue(std::int64_t{20}));
  EXPECT_EQ(ParameterDescriptor({"file", "", "", std::string("a")}).read("true"), ParameterValue(std::string("true")));
}

TEST(ParameterDescriptors, NameWhatTheyDoNotTake) {
  for (const char* text : {"", " 1", "1 ", "1 2", "much", "0x10", "010", "1,5", "1e400", "+1", "true", "nan", "inf"}) {
    EXPECT_EQ(refusalOf([&] { kMass.read(text); }), "mass '" + std::string(text) + "': must be a decimal number");
  }
  EXPECT_EQ(refusalOf([] { kMass.read("-1"); }), "mass -1.0: must be from 0.0 to 10.0 [kg]: it is a toy");
  EXPECT_EQ(refusalOf([] {
              ParameterDescriptor({"walls", "", "", false}).read("1");
            }),
            "walls '1': must be true or false");
  ParameterDescriptor preset{"preset", "", "", std::string("shaped")};
  preset.words = {"simple", "shaped"};
  EXPECT_EQ(refusalOf([&] { preset.read("round"); }), "preset 'round': must be one of: simple, shaped");
}

TEST(ParameterDescriptors, SayWhichValuesTheyTake) {
  constexpr double kUnbounded = std::numeric_limits<double>::infinity();
  EXPECT_EQ(kMass.range(), "from 0.0 to 10.0 [kg]");
  EXPECT_EQ(ParameterDescriptor({"sweeps", "", "", std::int64_t{1}, 1.0, 1000.0}).range(), "from 1 to 1000");
  EXPECT_EQ(ParameterDescriptor({"mass", "kg", "", 1.0, 0.1, kUnbounded}).range(), "at least 0.1 [kg]");
  EXPECT_EQ(ParameterDescriptor({"slope", "", "", 1.0, -kUnbounded, 2.5}).range(), "at most 2.5");
  EXPECT_EQ(ParameterDescriptor({"free", "", "", 1.0}).range(), "");
  EXPECT_EQ(ParameterDescriptor({"walls", "", "", false}).range(), "true or false");
  EXPECT_EQ(ParameterDescriptor({"scene", "", "", std::string()}).range(), "");
}

TEST(ValueOf, KeepsTypesApart) {
  EXPECT_EQ(valueOf("true"), ParameterValue(true));
  EXPECT_EQ(valueOf("false"), ParameterValue(false));
  EXPECT_EQ(valueOf("20"), ParameterValue(std::int64_t{20}));
  EXPECT_EQ(valueOf("-9223372036854775808"), ParameterValue(std::numeric_limits<std::int64_t>::min()));
  EXPECT_EQ(valueOf("20.0"), ParameterValue(20.0));
  EXPECT_EQ(valueOf("9223372036854775808"), ParameterValue(0x1p63));
  for (const char* text : {"", "010", "nan", "inf", "-inf", "1e400", "True", "two discs"}) {
    EXPECT_EQ(valueOf(text), ParameterValue(std::string(text)));
  }
}

TEST(ServiceName, RefusesWhatIsNone) {
  EXPECT_EQ(serviceName("policy", "/a/b_1"), "/a/b_1");
  for (const char* name : {"", "..", "a b", "\u00e9", "1a", "a//b:c"}) {
    EXPECT_EQ(refusalOf([&] { serviceName("policy", name); }),
              "policy '" + std::string(name) + "': must be a ROS name: letters, digits, _ and /");
  }
}

TEST(TextOf, ReadsBack) {
  for (const char* text : {"true", "false", "20", "20.0", "-1e-05", "two discs"}) {
    EXPECT_EQ(textOf(valueOf(text)), text);
  }
}

ParameterSet toy() { return ParameterSet({kMass, {"drag", "1/s", "", 6.0}, {"walls", "", "", false}}); }

TEST(ParameterSets, ChangeValuesAndKeepTheOrder) {
  EXPECT_EQ(merged(toy(), {}), toy());
  const ParameterSet changed = merged(toy(), {parameter("walls", "true"), parameter("mass", "1")});
  EXPECT_EQ(toMessages(changed),
            (Parameters{parameter("mass", "1.0"), parameter("drag", "6.0"), parameter("walls", "true")}));
  EXPECT_EQ(changed.get<double>("mass"), 1.0);
  EXPECT_TRUE(changed.at("drag").isDefault());
  EXPECT_FALSE(changed.at("walls").isDefault());
}

TEST(ParameterSets, AreRefusedAParameterThatIsSetTwice) {
  for (const Parameters& twice : {Parameters{parameter("drag", "1"), parameter("drag", "2")},
                                  Parameters{parameter("drag", "1"), parameter("mass", "2"), parameter("drag", "2")}}) {
    EXPECT_EQ(refusalOf([&] { merged(toy(), twice); }), "parameter drag 1, 2: must be set once");
    EXPECT_EQ(refusalOf([&] { changed({}, twice); }), "parameter drag 1, 2: must be set once");
  }
}

TEST(Changed, SetsEachParameterOnce) {
  EXPECT_EQ(
      changed({parameter("drag", "1"), parameter("mass", "2")}, {parameter("walls", "true"), parameter("drag", "3")}),
      (Parameters{parameter("drag", "3"), parameter("mass", "2"), parameter("walls", "true")}));
}

TEST(SameValue, IsOfNumbersOrTexts) {
  EXPECT_TRUE(sameValue("6", "6.0"));
  EXPECT_TRUE(sameValue("1e-3", "0.001"));
  EXPECT_TRUE(sameValue("shaped", "shaped"));
  EXPECT_FALSE(sameValue("6", "6.1"));
  EXPECT_FALSE(sameValue("6", "six"));
  EXPECT_FALSE(sameValue("true", "1"));
}

TEST(ParameterSets, APresetSetsWhatIsNotSetByName) {
  ParameterDescriptor level = {"level", "", "", std::string("high")};
  level.words = {"high", "low"};
  level.presets = {{"high", {{"drag", "6"}, {"walls", "true"}}}, {"low", {{"drag", "1"}, {"walls", "false"}}}};
  const ParameterSet defaults({level, {"drag", "1/s", "", 6.0}, {"walls", "", "", true}});
  const ParameterSet low = merged(defaults, {parameter("level", "low")});
  EXPECT_EQ(low.get<double>("drag"), 1.0);
  EXPECT_FALSE(low.get<bool>("walls"));
  const ParameterSet named = merged(defaults, {parameter("drag", "2"), parameter("level", "low")});
  EXPECT_EQ(named.get<double>("drag"), 2.0);
  EXPECT_EQ(merged(defaults, {parameter("level", "low"), parameter("drag", "2")}), named) << "in either order";
  EXPECT_EQ(merged(named, {parameter("level", "high")}).get<double>("drag"), 2.0) << "it stays";
  EXPECT_EQ(merged(low, {parameter("level", "high")}), defaults);
}

TEST(ParameterSets, NameWhatIsNotThere) {
  EXPECT_EQ(refusalOf([] { merged(toy(), {parameter("dragg", "1")}); }),
            "parameter 'dragg': unknown; known: mass, drag, walls");
  EXPECT_EQ(refusalOf([] { merged({}, {parameter("drag", "1")}); }), "parameter 'drag': unknown; known: none");
}

}  // namespace
}  // namespace pusht
