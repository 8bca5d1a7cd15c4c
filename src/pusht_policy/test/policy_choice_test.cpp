// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/policy_choice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "network_testing.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

using ::testing::HasSubstr;

const std::filesystem::path kShippedFile = std::filesystem::path(PUSHT_POLICIES_DIR) / "bc_policy.ts.pt";

TEST(ChoosePolicy, KnowsThePoliciesThatHaveAName) {
  for (const char* name : {kShippedPolicy, kExpertPolicy, kUntrainedPolicy}) {
    const ChosenPolicy chosen = choosePolicy({name, true, 0}, kShippedFile);
    ASSERT_TRUE(chosen.make()) << name;
    EXPECT_FALSE(chosen.identity.empty());
    EXPECT_EQ(chosen.name, name);
    EXPECT_EQ(chosen.warning, "");
    EXPECT_FALSE(chosen.provenance.at("runs_on").get<std::string>().empty());
  }
  const ChosenPolicy shipped = choosePolicy({}, kShippedFile);
  EXPECT_EQ(shipped.provenance.at("sha256").get<std::string>().size(), 64U);
}

TEST(ChoosePolicy, NamesAFileByItsPath) {
  const ChosenPolicy chosen = choosePolicy({kShippedFile.string()}, "none");
  EXPECT_EQ(chosen.name, kShippedFile.string());
  EXPECT_EQ(chosen.warning, "");
}

/// The course's guard, and its seed.
TEST(ChoosePolicy, AMissingFileIsReplacedWithAWarningIfThatIsAllowed) {
  const ChosenPolicy chosen = choosePolicy({"none.pt", false, 7, true}, kShippedFile);
  EXPECT_EQ(chosen.name, kUntrainedPolicy);
  EXPECT_THAT(chosen.warning, HasSubstr("policy none.pt: there is no such file. Running an UNTRAINED policy instead"));
  const auto observations = testing::observations();
  const ChosenPolicy same = choosePolicy({kUntrainedPolicy, false, 7}, kShippedFile);
  const ChosenPolicy other = choosePolicy({kUntrainedPolicy, false, 8}, kShippedFile);
  EXPECT_EQ(testing::act(*chosen.make(), observations), testing::act(*same.make(), observations));
  EXPECT_NE(testing::act(*chosen.make(), observations), testing::act(*other.make(), observations));
  EXPECT_EQ(chosen.identity, same.identity);
  EXPECT_NE(chosen.identity, other.identity);
}

TEST(ChoosePolicy, TheShippedFileIsReplacedWithAWarningUnlessItIsRequired) {
  const ChosenPolicy chosen = choosePolicy({kShippedPolicy}, "none.pt");
  EXPECT_EQ(chosen.name, kUntrainedPolicy);
  EXPECT_THAT(chosen.warning, HasSubstr("policy none.pt: there is no such file. Running an UNTRAINED policy instead"));
  EXPECT_THROW(choosePolicy({kShippedPolicy, true}, "none.pt"), InvalidInput);
}

TEST(ChoosePolicy, AFileThatIsNamedMustBeThere) {
  EXPECT_THROW(choosePolicy({"none.pt"}, kShippedFile), InvalidInput);
  EXPECT_THROW(choosePolicy({""}, kShippedFile), InvalidInput);
  EXPECT_THROW(choosePolicy({"", false, 0, true}, kShippedFile), InvalidInput);
}

}  // namespace
}  // namespace pusht
