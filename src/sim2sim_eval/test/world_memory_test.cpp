// SPDX-License-Identifier: BSD-3-Clause
#include "live/world_memory.hpp"

#include <gtest/gtest.h>

namespace sim2sim {
namespace {

using pusht::parameter;
using pusht::Parameters;

pusht_msgs::ParameterDescriptor descriptor(const std::string& name, const std::string& default_value) {
  pusht_msgs::ParameterDescriptor descriptor;
  descriptor.name = name;
  descriptor.default_value = default_value;
  return descriptor;
}

pusht_msgs::DescribeResponse twoMass(const std::string& drag) {
  pusht_msgs::DescribeResponse world;
  world.name = "two_mass";
  world.parameters = {parameter("drag", drag), parameter("mass", "4.0")};
  world.parameter_descriptors = {descriptor("drag", "6.0"), descriptor("mass", "4.0")};
  return world;
}

/// Its word "simple" sets `drag` to false; `walls` is no part of it.
pusht_msgs::DescribeResponse rigidBody(const std::string& preset, const std::string& drag, const std::string& walls) {
  pusht_msgs::DescribeResponse world;
  world.name = "rigid_body";
  world.parameters = {parameter("preset", preset), parameter("drag", drag), parameter("walls", walls)};
  world.parameter_descriptors = {descriptor("preset", "faithful"), descriptor("drag", "true"),
                                 descriptor("walls", "true")};
  pusht_msgs::Preset simple;
  simple.word = "simple";
  simple.settings = {parameter("drag", "false")};
  world.parameter_descriptors.front().presets = {simple};
  return world;
}

/// What a run does that asks for `asked` of the world `now`, and that has made it `then`.
WorldRequest run(WorldMemory& memory, const pusht_msgs::DescribeResponse& now, const WorldRequest& asked,
                 const pusht_msgs::DescribeResponse& then) {
  WorldRequest request = memory.resolve("/engine", now, asked);
  memory.configured("/engine", then);
  return request;
}

TEST(WorldMemories, LeaveAWorldAsItIsUntilARunHasChangedIt) {
  WorldMemory memory;
  const WorldRequest open = run(memory, twoMass("20.0"), {}, twoMass("20.0"));
  EXPECT_EQ(open.kind, "");
  EXPECT_EQ(open.parameters, Parameters());
  const WorldRequest heavy = run(memory, twoMass("20.0"), {"", {parameter("mass", "2")}}, twoMass("20.0"));
  EXPECT_EQ(heavy.parameters, Parameters{parameter("mass", "2")});
}

TEST(WorldMemories, DoNotLetARunInheritTheKindAndParametersOfTheOneBefore) {
  WorldMemory memory;
  const WorldRequest asked = {"rigid_body", {parameter("drag", "false")}};
  EXPECT_EQ(run(memory, twoMass("20.0"), asked, rigidBody("faithful", "false", "true")).kind, "rigid_body");

  const WorldRequest next = run(memory, rigidBody("faithful", "false", "true"), {}, twoMass("20.0"));
  EXPECT_EQ(next.kind, "two_mass");
  EXPECT_EQ(next.parameters, Parameters{parameter("drag", "20.0")}) << "as it was launched";

  run(memory, twoMass("20.0"), {"", {parameter("drag", "60")}}, twoMass("60.0"));
  const WorldRequest after = run(memory, twoMass("60.0"), {"", {parameter("mass", "2")}}, twoMass("20.0"));
  EXPECT_EQ(after.kind, "two_mass");
  EXPECT_EQ(after.parameters, (Parameters{parameter("drag", "20.0"), parameter("mass", "2")}));
}

TEST(WorldMemories, HoldWhatWasAskedForByNameOnTopOfTheFormer) {
  WorldMemory memory;
  run(memory, twoMass("20.0"), {"", {parameter("drag", "60")}}, twoMass("60.0"));
  const WorldRequest request = memory.resolve("/engine", twoMass("60.0"), {"", {parameter("drag", "2")}});
  EXPECT_EQ(request.parameters, Parameters{parameter("drag", "2")}) << "once";
}

TEST(WorldMemories, TakeWhatAnotherCallerHasConfigured) {
  WorldMemory memory;
  run(memory, twoMass("6.0"), {"", {parameter("drag", "60")}}, twoMass("60.0"));
  run(memory, twoMass("2.0"), {"", {parameter("drag", "60")}}, twoMass("60.0"));  // was set to 2 by hand
  EXPECT_EQ(memory.resolve("/engine", twoMass("60.0"), {}).parameters, Parameters{parameter("drag", "2.0")});
}

TEST(WorldMemories, UndoAConfigurationOfWhichNothingWasHeard) {
  WorldMemory memory;
  memory.resolve("/engine", twoMass("20.0"), {"rigid_body", {}});  // the node dies meanwhile, and comes back
  const WorldRequest request = memory.resolve("/engine", rigidBody("faithful", "true", "true"), {});
  EXPECT_EQ(request.kind, "two_mass");
  EXPECT_EQ(request.parameters, Parameters{parameter("drag", "20.0")});
}

TEST(WorldMemories, KeepWorldsApart) {
  WorldMemory memory;
  run(memory, twoMass("6.0"), {"", {parameter("drag", "60")}}, twoMass("60.0"));
  EXPECT_EQ(memory.resolve("/other", twoMass("60.0"), {}).kind, "");
}

TEST(WorldMemories, KnowWhatAWorldWas) {
  WorldMemory memory;
  EXPECT_EQ(memory.kindOf("/engine"), "");
  run(memory, twoMass("6.0"), {"rigid_body", {}}, rigidBody("faithful", "true", "true"));
  EXPECT_EQ(memory.kindOf("/engine"), "two_mass");
}

TEST(SettingOf, IsTheShortestThatMakesTheWorld) {
  EXPECT_EQ(requestFor(twoMass("6")).parameters, Parameters()) << "6 is the default, 6.0";
  EXPECT_EQ(requestFor(twoMass("20.0")).parameters, Parameters{parameter("drag", "20.0")});
  EXPECT_EQ(requestFor(rigidBody("simple", "false", "true")).parameters, Parameters{parameter("preset", "simple")});
  EXPECT_EQ(requestFor(rigidBody("simple", "true", "false")).parameters,
            (Parameters{parameter("preset", "simple"), parameter("drag", "true"), parameter("walls", "false")}));
  pusht_msgs::DescribeResponse undescribed = twoMass("6.0");
  undescribed.parameter_descriptors.clear();
  EXPECT_EQ(requestFor(undescribed).parameters, undescribed.parameters);
}

}  // namespace
}  // namespace sim2sim
