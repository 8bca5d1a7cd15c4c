// SPDX-License-Identifier: BSD-3-Clause
#include "strip_layout.hpp"

#include <gmock/gmock.h>

namespace pusht_rviz {
namespace {

TEST(StripLayout, HasLargeSquaresForFewEpisodes) {
  const StripLayout layout = layOut(50, 0, 360, 48, 6, 16);
  EXPECT_EQ(layout.pitch, 16);
  EXPECT_EQ(layout.columns, 22);
  EXPECT_EQ(layout.rows(), 3);
  EXPECT_EQ(layout.begin, 0U);
  EXPECT_EQ(layout.end, 50U);
}

TEST(StripLayout, HasSmallerSquaresForMoreEpisodes) {
  const StripLayout layout = layOut(200, 0, 360, 48, 6, 16);
  EXPECT_LT(layout.pitch, 16);
  EXPECT_EQ(layout.end, 200U) << "all fit";
  EXPECT_LE(layout.rows() * layout.pitch, 48);
}

TEST(StripLayout, ShowsThoseAroundTheEpisodeThatIsShownWhereNotAllFit) {
  for (const std::uint64_t shown : {0U, 999U, 5000U, 9999U}) {
    const StripLayout layout = layOut(10'000, shown, 360, 48, 6, 16);
    EXPECT_EQ(layout.pitch, 6);
    EXPECT_LE(layout.begin, shown);
    EXPECT_GT(layout.end, shown);
    EXPECT_LE(layout.rows() * layout.pitch, 48);
    EXPECT_EQ(layout.begin % static_cast<std::uint64_t>(layout.columns), 0U) << "whole rows";
  }
}

TEST(StripLayout, FindsEachSquareWhereItIs) {
  const StripLayout layout = layOut(10'000, 5000, 360, 48, 6, 16);
  for (std::uint64_t index = layout.begin; index < layout.end; ++index) {
    EXPECT_EQ(layout.indexAt(layout.left(index) + 3, layout.top(index) + 3), index);
  }
  EXPECT_EQ(layout.indexAt(-1, 0), std::nullopt);
  EXPECT_EQ(layout.indexAt(359, 47), layout.end - 1);
  EXPECT_EQ(layout.indexAt(360, 0), std::nullopt);
  EXPECT_EQ(layout.indexAt(0, 48), std::nullopt);
}

TEST(StripLayout, HasNoSquaresWithoutEpisodes) {
  const StripLayout layout = layOut(0, 0, 360, 48, 6, 16);
  EXPECT_EQ(layout.rows(), 0);
  EXPECT_EQ(layout.indexAt(0, 0), std::nullopt);
}

TEST(StripLayout, StandsAnyWidth) {
  const StripLayout layout = layOut(50, 49, 0, 0, 6, 16);
  EXPECT_EQ(layout.columns, 1);
  EXPECT_EQ(layout.indexAt(0, 0), 49U);
}

}  // namespace
}  // namespace pusht_rviz
