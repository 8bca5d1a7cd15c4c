// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/numbers.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <optional>

namespace pusht {
namespace {

TEST(Decimal, IsAllOfTheTextAndHasNoLeadingZero) {
  EXPECT_EQ(decimal<int>("10"), 10);
  EXPECT_EQ(decimal<int>("-3"), -3);
  EXPECT_EQ(decimal<int>("0"), 0);
  EXPECT_EQ(decimal<double>("0.5"), 0.5);
  EXPECT_EQ(decimal<double>("-0.5e-3"), -0.5e-3);
  EXPECT_EQ(decimal<std::uint64_t>("18446744073709551615"), 18446744073709551615U);
  for (const char* text : {"", "-", " 1", "1 ", "+1", "0x10", "010", "-010", "00", "1,5", "ten"}) {
    EXPECT_EQ(decimal<int>(text), std::nullopt) << text;
    EXPECT_EQ(decimal<double>(text), std::nullopt) << text;
  }
  for (const char* text : {"inf", "-inf", "infinity", "nan", "-nan", "NaN", "1e400"}) {
    EXPECT_EQ(decimal<double>(text), std::nullopt) << text;
  }
  EXPECT_EQ(decimal<std::uint64_t>("18446744073709551616"), std::nullopt);
}

/// What Python 3 prints for repr().
TEST(ShortestText, IsPythons) {
  EXPECT_EQ(shortestText(4.0), "4.0");
  EXPECT_EQ(shortestText(-0.0), "-0.0");
  EXPECT_EQ(shortestText(0.1), "0.1");
  EXPECT_EQ(shortestText(0.1 + 0.2), "0.30000000000000004");
  EXPECT_EQ(shortestText(1e-4), "0.0001");
  EXPECT_EQ(shortestText(1e-5), "1e-05");
  EXPECT_EQ(shortestText(1.5e-7), "1.5e-07");
  EXPECT_EQ(shortestText(1e15), "1000000000000000.0");
  EXPECT_EQ(shortestText(123456789012345680.0), "1.2345678901234568e+17");
  EXPECT_EQ(shortestText(1e16), "1e+16");
  EXPECT_EQ(shortestText(1e300), "1e+300");
  EXPECT_EQ(shortestText(5e-324), "5e-324");
}

TEST(FixedText, RoundsCorrectly) {
  EXPECT_EQ(fixedText(0.0625, 3), "0.062") << "an exact tie goes to even";
  EXPECT_EQ(fixedText(2.0 / 3.0, 4), "0.6667");
  EXPECT_EQ(fixedText(32.0, 0), "32");
}

/// What Python 3 gives for round(value, 6).
TEST(RoundToMicro, IsPythons) {
  EXPECT_EQ(roundToMicro(0.0040374999), 0.004037);
  EXPECT_EQ(roundToMicro(2.0 / 3.0), 0.666667);
  EXPECT_EQ(roundToMicro(0.0000005), 0.0) << "0.0000005 is a little below the tie as a double";
  EXPECT_EQ(roundToMicro(0.0000015), 0.000002) << "0.0000015 is a little above it";
  EXPECT_EQ(roundToMicro(0.62), 0.62);
  EXPECT_EQ(roundToMicro(1e15), 1e15);
}

TEST(SignificantText, HasTheDigitsThatCount) {
  EXPECT_EQ(significantText(0.0123456, 3), "0.0123");
  EXPECT_EQ(significantText(1.23456e-9, 3), "1.23e-09");
  EXPECT_EQ(significantText(67.9, 2), "68");
  EXPECT_EQ(significantText(0.0, 3), "0");
}

}  // namespace
}  // namespace pusht
