// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/split.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pusht {
namespace {

using ::testing::ElementsAre;

TEST(Split, HasAPartMoreThanThereAreSeparators) {
  EXPECT_THAT(split("a,b", ','), ElementsAre("a", "b"));
  EXPECT_THAT(split("a", ','), ElementsAre("a"));
  EXPECT_THAT(split("", ','), ElementsAre(""));
  EXPECT_THAT(split("a,", ','), ElementsAre("a", ""));
  EXPECT_THAT(split(",", ','), ElementsAre("", ""));
  EXPECT_THAT(split("a,,b", ','), ElementsAre("a", "", "b"));
  EXPECT_THAT(split(" a ,b\n", ','), ElementsAre(" a ", "b\n"));
  EXPECT_THAT(split("a,b", '\n'), ElementsAre("a,b"));
}

}  // namespace
}  // namespace pusht
