// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/ros/parameters.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
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
  EXPECT_TRUE(std::isnan(realFromText("mass", "nan"))) << "whether it must be finite is for the caller to say";
}

TEST(RealFromText, NamesWhatIsNone) {
  for (const char* text : {"", " 1", "1 ", "1 2", "much", "0x10", "010", "1,5", "1e400", "+1", "true"}) {
    EXPECT_EQ(refusalOf([&] { realFromText("mass", text); }),
              "mass '" + std::string(text) + "': must be a decimal number");
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
