// SPDX-License-Identifier: BSD-3-Clause
#include "texts.hpp"

#include <gmock/gmock.h>

#include <limits>

#include "pusht_testing/decimal_comma.hpp"

namespace pusht_rviz {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Texts, OfMeansAreThoseOfTheMessage) {
  pusht_msgs::Summary summary;
  summary.means.resize(2);
  summary.means[0].name = "mean_pos_divergence";
  summary.means[0].text = "0.0817 m [0.0692, 0.0964] (!)";
  summary.means[1].name = "without_episodes";
  EXPECT_EQ(meanText(summary, "mean_pos_divergence"), "0.0817 m [0.0692, 0.0964] (!)");
  EXPECT_EQ(meanText(summary, "without_episodes"), kDash);
  EXPECT_EQ(meanText(summary, "of_no_such_name"), kDash);
  EXPECT_EQ(orDash(summary.transfer_text), kDash);
}

TEST(Texts, CountPairs) {
  pusht_msgs::Summary summary;
  EXPECT_EQ(pairsText(summary), kDash);
  summary.episodes_finished = 50;
  summary.both_succeed = 6;
  summary.only_reference_succeeds = 24;
  summary.only_engine_succeeds = 5;
  summary.neither_succeeds = 15;
  EXPECT_EQ(pairsText(summary), "both solve 6, only reference 24, only engine 5, neither 15");
}

TEST(Texts, TimeLeftIsRoundedUp) {
  EXPECT_EQ(timeLeftText(kNan), "");
  EXPECT_EQ(timeLeftText(0.0), "0 s left");
  EXPECT_EQ(timeLeftText(44.2), "45 s left");
  EXPECT_EQ(timeLeftText(59.5), "1 min left");
  EXPECT_EQ(timeLeftText(61.0), "2 min left");
  EXPECT_EQ(timeLeftText(3599.0), "1 h 0 min left");
  EXPECT_EQ(timeLeftText(7500.0), "2 h 5 min left");
}

TEST(Texts, PaceIsInControlStepsASecond) {
  EXPECT_EQ(paceText(50.0), "50 Hz");
  EXPECT_EQ(paceText(0.5), "0.5 Hz");
  EXPECT_EQ(paceText(0.0), "as fast as possible");
}

/// A program of Qt takes the user's locale.
TEST(Texts, F24AreTheSameWhereTheUserWritesAComma) {
  const pusht::testing::DecimalComma locale;
  EXPECT_EQ(paceText(0.5), "0.5 Hz");
}

}  // namespace
}  // namespace pusht_rviz
