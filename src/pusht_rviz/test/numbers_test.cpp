// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_rviz/numbers.hpp"

#include <gmock/gmock.h>

#include <cstdint>
#include <limits>

#include "pusht_task/testing/decimal_comma.hpp"

namespace pusht_rviz {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

pusht_msgs::SuccessRate rate(std::uint32_t successes, std::uint32_t trials, double low, double high) {
  pusht_msgs::SuccessRate made;
  made.successes = successes;
  made.trials = trials;
  made.rate = trials == 0 ? kNan : static_cast<double>(successes) / trials;
  made.low = low;
  made.high = high;
  return made;
}

pusht_msgs::Mean mean(const char* name, const char* unit, double value, double low, double high) {
  pusht_msgs::Mean made;
  made.name = name;
  made.unit = unit;
  made.value = value;
  made.low = low;
  made.high = high;
  return made;
}

pusht_msgs::Summary transfer(double value, double low, double high) {
  pusht_msgs::Summary summary;
  summary.reference.trials = 50;
  summary.transfer = value;
  summary.transfer_low = low;
  summary.transfer_high = high;
  return summary;
}

TEST(Numbers, RatesReadAsInTheTerminal) {
  EXPECT_EQ(rateText(rate(30, 50, 0.4618145, 0.7239161)), "30/50  0.600 [0.462, 0.724]");
  EXPECT_EQ(rateText(rate(0, 0, kNan, kNan)), kDash);
  EXPECT_EQ(rateText(rate(0, 3, kNan, kNan)), "0/3  0.000");
}

TEST(Numbers, TransferIsInPercent) {
  EXPECT_EQ(transferText(transfer(0.3666667, 0.2149, 0.6051)), "37 % [21 %, 61 %]");
  EXPECT_EQ(transferText(transfer(1.5, 0.9, kInf)), "150 % [90 %, any]");
  EXPECT_EQ(transferText(transfer(0.496, 0.4, 0.5004)), "49.6 % [40 %, 50.04 %]") << "on their side of 50 %";
  EXPECT_EQ(transferText(transfer(0.5, kNan, kNan)), "50 %");
  EXPECT_EQ(transferText(transfer(kNan, kNan, kNan)), kDash);
  EXPECT_EQ(transferText(pusht_msgs::Summary()), kDash) << "before the first episode has finished";
}

TEST(Numbers, MeansHaveFourDigitsAndTheirUnit) {
  pusht_msgs::Summary summary;
  summary.means = {mean("mean_pos_divergence", "m", 0.0817123, 0.0692, 0.0964),
                   mean("mean_ang_divergence", "rad", 0.9528, kNan, kNan), mean("none", "m", kNan, kNan, kNan)};
  EXPECT_EQ(meanText(summary, "mean_pos_divergence"), "0.0817 m [0.0692, 0.0964]");
  EXPECT_EQ(meanText(summary, "mean_ang_divergence"), "0.9528 rad");
  summary.means[0].mark = "(!)";
  summary.means[1].mark = "(?)";
  EXPECT_EQ(meanText(summary, "mean_pos_divergence"), "0.0817 m [0.0692, 0.0964] (!)");
  EXPECT_EQ(meanText(summary, "mean_ang_divergence"), "0.9528 rad (?)");
  EXPECT_EQ(meanText(summary, "none"), kDash);
  EXPECT_EQ(meanText(summary, "of_no_such_name"), kDash);
}

/// metrics.json has six decimals, or six digits that count; the terminal rounds those. To round once would differ.
TEST(Numbers, RoundTwiceAsFilesAndTerminalDo) {
  EXPECT_EQ(fixedText(0.0624999999, 3), "0.062") << "0.062500 in the file, a tie, which goes to the even digit";
  EXPECT_EQ(fixedText(0.3126499999, 4), "0.3126");
  EXPECT_EQ(fixedText(0.1234999, 3), "0.123");
  EXPECT_EQ(fixedText(0.9999996, 3), "1.000");
  EXPECT_EQ(fixedText(0.00049999999, 4), "0.0005") << "small ones have six digits that count: 0.0005";
  EXPECT_EQ(fixedText(0.0004499999, 4), "0.0004");
  EXPECT_EQ(fixedText(kNan, 3), kDash);
}

TEST(Numbers, TimeLeftIsRoundedUp) {
  EXPECT_EQ(timeLeftText(kNan), "");
  EXPECT_EQ(timeLeftText(0.0), "0 s left");
  EXPECT_EQ(timeLeftText(44.2), "45 s left");
  EXPECT_EQ(timeLeftText(59.5), "1 min left");
  EXPECT_EQ(timeLeftText(61.0), "2 min left");
  EXPECT_EQ(timeLeftText(3599.0), "1 h 0 min left");
  EXPECT_EQ(timeLeftText(7500.0), "2 h 5 min left");
}

TEST(Numbers, PaceIsInControlStepsASecond) {
  EXPECT_EQ(paceText(50.0), "50 Hz");
  EXPECT_EQ(paceText(0.5), "0.5 Hz");
  EXPECT_EQ(paceText(0.0), "as fast as possible");
}

TEST(Numbers, AreReadStrictly) {
  EXPECT_EQ(decimal<double>("1e9"), 1e9);
  EXPECT_EQ(decimal<double>("-0.5"), -0.5);
  EXPECT_EQ(decimal<std::uint32_t>("4294967295"), 4294967295U);
  for (const char* const text : {"", " 1", "1 ", "1,5", "0x10", "010", "inf", "nan", "1e999", "abc", "+1"}) {
    EXPECT_FALSE(decimal<double>(text)) << text;
  }
  EXPECT_FALSE(decimal<std::uint32_t>("4294967296"));
  EXPECT_FALSE(decimal<std::uint32_t>("-1"));
  EXPECT_FALSE(decimal<std::uint32_t>("1.0"));
}

/// A program of Qt takes the user's locale.
TEST(Numbers, F24AreTheSameWhereTheUserWritesAComma) {
  const pusht::testing::DecimalComma locale;
  pusht_msgs::Summary summary;
  summary.means = {mean("divergence", "m", 0.0817123, 0.0692, 0.0964)};
  EXPECT_EQ(meanText(summary, "divergence"), "0.0817 m [0.0692, 0.0964]");
  EXPECT_EQ(rateText(rate(30, 50, 0.4618145, 0.7239161)), "30/50  0.600 [0.462, 0.724]");
  EXPECT_EQ(fixedText(1234567.5, 3), "1234567.500");
  EXPECT_EQ(shortText(1234567.5), "1234567.5");
  EXPECT_EQ(paceText(0.5), "0.5 Hz");
  EXPECT_EQ(decimal<double>("6.5"), 6.5);
  EXPECT_FALSE(decimal<double>("6,5"));
}

}  // namespace
}  // namespace pusht_rviz
