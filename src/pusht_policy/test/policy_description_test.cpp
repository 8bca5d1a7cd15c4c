// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/policy_description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Message with which a description is refused.
std::string refusalOf(const std::string& text) {
  try {
    descriptionFrom(text, "policy x.pt: policy.json");
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    EXPECT_LT(std::string(error.what()).size(), 400U);
    return error.what();
  }
  return "accepted";
}

/// A sound description with `more` before its end.
std::string with(const std::string& more) {
  return R"({"format": 1, "observations": 2, "actions": 8)" + (more.empty() ? "" : ", " + more) + "}";
}

TEST(PolicyDescriptions, HaveAllThatIsWritten) {
  const PolicyDescription description = descriptionFrom(
      with(R"("execute": 4, "state": {"shape": [2, 64]}, "noise": {"shape": [8, 2], "distribution": "uniform"})"), "x");
  EXPECT_EQ(description.observations, 2);
  EXPECT_EQ(description.actions, 8);
  EXPECT_EQ(description.execute, 4);
  EXPECT_EQ(description.state, (PolicyDescription::Shape{2, 64}));
  EXPECT_EQ(description.noise, (PolicyDescription::Shape{8, 2}));
  EXPECT_EQ(description.distribution, PolicyDescription::Distribution::kUniform);
  EXPECT_TRUE(description.isStochastic());
  EXPECT_EQ(description.inputs(), "float [1, 2, 10], state float [1, 2, 64], noise float [1, 8, 2]");
  EXPECT_EQ(description.outputs(), "float [1, 8, 2], state float [1, 2, 64]");
  EXPECT_EQ(toJson(descriptionFrom(toJson(description).dump(), "x")), toJson(description));
}

TEST(PolicyDescriptions, ExecuteAllActionsUnlessTheySayOtherwise) {
  const PolicyDescription description = descriptionFrom(with(""), "x");
  EXPECT_EQ(description.execute, 8);
  EXPECT_FALSE(description.isStochastic());
  EXPECT_TRUE(description.hasMemory());
  EXPECT_FALSE(descriptionFrom(R"({"format": 1, "observations": 1, "actions": 1})", "x").hasMemory());
}

TEST(PolicyDescriptions, WithoutOneThePlainContractHolds) {
  EXPECT_EQ(PolicyDescription().inputs(), "float [1, 10]");
  EXPECT_EQ(PolicyDescription().outputs(), "float [1, 2]");
  EXPECT_FALSE(PolicyDescription().hasMemory());
}

TEST(PolicyDescriptions, AreRefusedByNameValueAndRule) {
  const std::string state = R"("state": )";
  const std::string noise = R"("noise": )";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "must be JSON, but is not at byte 1"},
      {"{", "must be JSON, but is not at byte 2"},
      {"not json", "must be JSON, but is not at byte"},
      {std::string("{\"format\": 1}\0", 14), "must be JSON, but is not at byte"},
      {std::string(70'000, ' '), "has 70000 bytes, must have at most 65536"},
      {std::string(60'000, '['), "must be JSON, but is not at byte"},
      {"[]", "[] must be an object with the keys format, observations, actions, execute, state, noise"},
      {"null", "null must be an object"},
      {"{}", "must have the key format"},
      {R"({"format": 2})", "format 2: must be 1, the one that this version reads"},
      {R"({"format": "1"})", R"(format "1": must be 1)"},
      {R"({"format": 1, "actions": 1})", "must have the key observations"},
      {R"({"format": 1, "observations": 1})", "must have the key actions"},
      {R"({"format": 1, "observations": 0, "actions": 1})", "observations 0: must be a whole number from 1 to 1000"},
      {R"({"format": 1, "observations": -1, "actions": 1})", "observations -1: must be"},
      {R"({"format": 1, "observations": 1001, "actions": 1})", "observations 1001: must be"},
      {R"({"format": 1, "observations": 18446744073709551615, "actions": 1})",
       "observations 18446744073709551615: must"},
      {R"({"format": 1, "observations": 1e300, "actions": 1})", "observations 1e+300: must be a whole number"},
      {R"({"format": 1, "observations": 2.0, "actions": 1})", "observations 2.0: must be a whole number"},
      {R"({"format": 1, "observations": "2", "actions": 1})", R"(observations "2": must be a whole number)"},
      {R"({"format": 1, "observations": true, "actions": 1})", "observations true: must be a whole number"},
      {R"({"format": 1, "observations": 1, "actions": 2000000000})",
       "actions 2000000000: must be a whole number from 1"},
      {with(R"("execute": 9)"), "execute 9: must be a whole number from 1 to 8, the actions of an answer"},
      {with(R"("execute": 0)"), "execute 0: must be a whole number from 1 to 8"},
      {with(R"("execute": null)"), "execute null: must be"},
      {with(R"("chunk": 8)"), R"(key "chunk" is unknown; the keys are format, observations)"},
      {with(R"("a\nb": 8)"), R"(key "a\nb" is unknown)"},
      {with("\"" + std::string(5000, 'k') + "\": 8"), "bytes left out"},
      {with(R"("actions": 9)"), R"(key "actions" is there twice)"},
      {with(state + "64"), "state: 64 must be an object with the keys shape"},
      {with(state + "{}"), "state: must have the key shape"},
      {with(state + R"({"shape": [64], "size": 1})"), R"(state: key "size" is unknown; the keys are shape)"},
      {with(state + R"({"shape": []})"),
       "state: shape []: must be 1 to 8 whole numbers whose product is at most 65536"},
      {with(state + R"({"shape": 64})"), "state: shape 64: must be"},
      {with(state + R"({"shape": [64, 0]})"), "state: shape [64,0]: must be"},
      {with(state + R"({"shape": [1.5]})"), "state: shape [1.5]: must be"},
      {with(state + R"({"shape": [65536, 65536, 65536, 65536, 65536]})"), "state: shape [65536,65536,"},
      {with(state + R"({"shape": [257, 256]})"), "state: shape [257,256]: must be"},
      {with(state + R"({"shape": [1, 1, 1, 1, 1, 1, 1, 1, 1]})"), "state: shape [1,1,1,1,1,1,1,1,1]: must be 1 to 8"},
      {with(noise + R"({"shape": [2]})"), "noise: must have the key distribution"},
      {with(noise + R"({"distribution": "normal"})"), "noise: must have the key shape"},
      {with(noise + R"({"shape": [2], "distribution": "gaussian"})"),
       R"(noise: distribution "gaussian": must be "normal" or "uniform")"},
      {with(noise + R"({"shape": [2], "distribution": 1})"), "noise: distribution 1: must be"},
      {with(noise + R"({"shape": [2], "distribution": "normal", "mean": 0})"), R"(noise: key "mean" is unknown)"},
      {with(noise + R"({"shape": [2], "shape": [3], "distribution": "normal"})"), R"(key "shape" is there twice)"},
      {with(R"("interface": "gym")"), R"(interface "gym": must be one of full_circle, gym_state, gym_keypoints)"},
      {with(R"("interface": "gym_keypoints")"), "must have the key keypoints"},
      {with(R"("interface": "gym_keypoints", "keypoints": 10, "agent": "last")"), "keypoints 10: must be 8, the tee's"},
      {with(R"("interface": "gym_keypoints", "keypoints": 8)"), "must have the key agent"},
      {with(R"("interface": "gym_keypoints", "keypoints": 8, "agent": 0)"), "agent 0: must be one of first, last"},
      {with(R"("interface": "gym_state", "agent": "last")"), "key agent must be left out with the interface gym_state"},
      {with(R"("keypoints": 8)"), "key keypoints must be left out with the interface full_circle"},
  };
  for (const auto& [text, message] : cases) {
    EXPECT_THAT(refusalOf(text), HasSubstr(message)) << text.substr(0, 200);
    EXPECT_THAT(refusalOf(text), HasSubstr("policy x.pt: policy.json: ")) << text.substr(0, 200);
  }
}

TEST(PolicyDescriptions, SayWhatThePolicySees) {
  const auto read = [](const std::string& more) { return descriptionFrom(with(more), "policy.json"); };
  EXPECT_EQ(read(R"("interface": "full_circle")").interface, PolicyInterface());
  EXPECT_FALSE(toJson(read(R"("interface": "full_circle")")).contains("interface")) << "as before there was one";
  EXPECT_EQ(read(R"("interface": "gym_state")").inputs(), "float [1, 2, 5]");
  const PolicyDescription keypoints = read(R"("interface": "gym_keypoints", "keypoints": 9, "agent": "first")");
  EXPECT_EQ(keypoints.inputs(), "float [1, 2, 20]");
  EXPECT_TRUE(keypoints.interface.agent_first);
  EXPECT_EQ(descriptionFrom(toJson(keypoints).dump(), "again").interface, keypoints.interface);
}

TEST(PolicyDescriptions, AreTakenAtTheirLimits) {
  EXPECT_EQ(refusalOf(R"({"format": 1, "observations": 1000, "actions": 1000, "execute": 1000})"), "accepted");
  EXPECT_EQ(refusalOf(with(R"("state": {"shape": [256, 256]})")), "accepted");
  EXPECT_EQ(refusalOf(with(R"("noise": {"shape": [1, 1, 1, 1, 1, 1, 1, 65536], "distribution": "normal"})")),
            "accepted");
}

}  // namespace
}  // namespace pusht
