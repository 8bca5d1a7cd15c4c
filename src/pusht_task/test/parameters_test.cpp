// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/ros/parameters.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <limits>
#include <string>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

std::string refusalOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InvalidInput& refusal) {
    return refusal.what();
  }
  return "not refused";
}

TEST(RealFromText, ReadsDecimalNumbers) {
  EXPECT_EQ(realFromText("mass", "6"), 6.0);
  EXPECT_EQ(realFromText("mass", "-0.25"), -0.25);
  EXPECT_EQ(realFromText("mass", "1e-3"), 1e-3);
  EXPECT_EQ(realFromText("mass", "0.1"), 0.1);
}

TEST(RealFromText, NamesWhatIsNone) {
  for (const char* text : {"", " 1", "1 ", "1 2", "much", "0x10", "010", "1,5", "1e400", "+1", "true", "nan", "inf"}) {
    EXPECT_EQ(refusalOf([&] { realFromText("mass", text); }),
              "mass '" + std::string(text) + "': must be a decimal number");
  }
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

TEST(Merged, ChangesValuesAndKeepsTheOrder) {
  const Parameters defaults = {parameter("mass", "4"), parameter("drag", "6"), parameter("walls", "false")};
  EXPECT_EQ(merged(defaults, {}), defaults);
  const Parameters changed = merged(defaults, {parameter("walls", "true"), parameter("mass", "1")});
  EXPECT_EQ(changed, (Parameters{parameter("mass", "1"), parameter("drag", "6"), parameter("walls", "true")}));
  EXPECT_EQ(merged(defaults, {parameter("drag", "1"), parameter("drag", "2")})[1].value, "2");
}

TEST(Merged, NamesWhatIsNotThere) {
  const Parameters defaults = {parameter("mass", "4"), parameter("drag", "6")};
  EXPECT_EQ(refusalOf([&] { merged(defaults, {parameter("dragg", "1")}); }),
            "parameter 'dragg': there is none of that name; there are: drag, mass");
  EXPECT_EQ(refusalOf([] { merged({}, {parameter("drag", "1")}); }),
            "parameter 'drag': there is none of that name; there are: none");
}

}  // namespace
}  // namespace pusht
