// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/rollout_ids.hpp"

#include <gtest/gtest.h>

namespace pusht {
namespace {

TEST(RolloutIds, OfTwoCallersDiffer) {
  RolloutIds mine;
  RolloutIds yours;
  const std::uint64_t first = mine.next();
  EXPECT_NE(first, yours.next());
  EXPECT_NE(first, 0U) << "what is sent by hand";
  for (std::uint64_t count = 1; count < 10; ++count) {
    EXPECT_EQ(mine.next(), first + count);
  }
}

}  // namespace
}  // namespace pusht
