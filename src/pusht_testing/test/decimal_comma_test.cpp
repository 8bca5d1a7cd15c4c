// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_testing/decimal_comma.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "pusht_task/numbers.hpp"

namespace pusht {
namespace {

TEST(Numbers, F24AreTheSameWhereTheUserWritesAComma) {
  const testing::DecimalComma locale;
  EXPECT_EQ(shortestText(6.5), "6.5");
  EXPECT_EQ(shortestText(1234567.5), "1234567.5");
  EXPECT_EQ(shortestText(4.0), "4.0");
  EXPECT_EQ(shortestText(1.5e-7), "1.5e-07");
  EXPECT_EQ(fixedText(1234567.5, 3), "1234567.500");
  EXPECT_EQ(significantText(0.0123456, 3), "0.0123");
  EXPECT_EQ(decimal<double>("6.5"), 6.5);
  EXPECT_EQ(decimal<double>("6,5"), std::nullopt);
  EXPECT_EQ(decimal<int>("1.000"), std::nullopt);
  EXPECT_EQ(roundToMicro(2.0 / 3.0), 0.666667);
}

}  // namespace
}  // namespace pusht
