// SPDX-License-Identifier: BSD-3-Clause
#include "curve_store.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "pusht_task/constants.hpp"

namespace pusht_rviz {
namespace {

pusht_msgs::Divergence divergence(std::uint64_t episode, std::uint32_t step, double position = 0.01) {
  pusht_msgs::Divergence made;
  made.episode = episode;
  made.step = step;
  made.replay_position = position;
  made.replay_angle = 10.0 * position;
  made.closed_position = 0.5 * position;
  made.closed_angle = std::numeric_limits<double>::quiet_NaN();
  made.null_position = 9.0;
  made.null_angle = 9.0;
  return made;
}

TEST(CurveStore, KeepsWhatComesWithItsTime) {
  CurveStore store;
  store.add(divergence(7, 1, 0.02));
  store.add(divergence(7, 2, 0.04));
  ASSERT_EQ(store.current().points.size(), 2U);
  EXPECT_EQ(store.current().episode, 7U);
  const CurvePoint& last = store.current().points.back();
  EXPECT_DOUBLE_EQ(last.time, 0.2);
  EXPECT_DOUBLE_EQ(last.values[kReplayCurve][kPosition], 0.04);
  EXPECT_DOUBLE_EQ(last.values[kClosedCurve][kPosition], 0.02);
  EXPECT_TRUE(std::isnan(last.values[kClosedCurve][kAngle]));
  EXPECT_DOUBLE_EQ(store.end(), 0.2);
  EXPECT_DOUBLE_EQ(store.cursor(), 0.2);
}

TEST(CurveStore, MovesAnEpisodeThatEndedToTheEarlierOnes) {
  CurveStore store;
  store.add(divergence(0, 1));
  const std::uint64_t before = store.earlierVersion();
  store.add(divergence(0, 2));
  EXPECT_EQ(store.earlierVersion(), before) << "or all of the earlier ones would be drawn again for each step";
  store.add(divergence(1, 1));
  EXPECT_NE(store.earlierVersion(), before);
  ASSERT_EQ(store.earlier().size(), 1U);
  EXPECT_EQ(store.earlier().front().points.size(), 2U);
  EXPECT_EQ(store.current().points.size(), 1U);
}

TEST(CurveStore, ForgetsTheOldestOfMany) {
  CurveStore store;
  for (std::uint64_t episode = 0; episode < 200; ++episode) {
    store.add(divergence(episode, 1));
  }
  EXPECT_EQ(store.earlier().size(), CurveStore::kKept);
  EXPECT_EQ(store.earlier().back().episode, 198U);
}

TEST(CurveStore, TakesAnEpisodeThatBeginsAgain) {
  CurveStore store;
  for (std::uint32_t step = 1; step <= 9; ++step) {
    store.add(divergence(3, step));
  }
  store.add(divergence(3, 4, 0.5));
  EXPECT_EQ(store.current().points.size(), 4U) << "what came from there on is of the course before";
  EXPECT_DOUBLE_EQ(store.current().points.back().values[kReplayCurve][kPosition], 0.5);
  store.add(divergence(4, 1));
  store.add(divergence(3, 1));
  EXPECT_EQ(store.earlier().size(), 1U) << "no episode is there twice";
  EXPECT_EQ(store.earlier().front().episode, 4U);
}

TEST(CurveStore, OfAReplayKeepsTheWholeEpisodeWhateverIsSought) {
  CurveStore store;
  store.setReplay(true);
  for (std::uint32_t step = 0; step <= 9; ++step) {
    store.add(divergence(3, step, 0.01 * step));
  }
  store.add(divergence(3, 4, 0.04));
  ASSERT_EQ(store.current().points.size(), 10U);
  for (std::size_t step = 0; step <= 9; ++step) {
    EXPECT_DOUBLE_EQ(store.current().points[step].time, pusht::kControlStep * static_cast<double>(step));
  }
  EXPECT_DOUBLE_EQ(store.cursor(), 0.4);
  store.add(divergence(3, 12));
  store.add(divergence(3, 11));
  EXPECT_DOUBLE_EQ(store.current().points.back().time, 1.2) << "in the order of time";
}

TEST(CurveStore, IsWholeForALatePanel) {
  CurveStore late;
  late.add(divergence(3, 7));  // the latched one
  std::vector<pusht_msgs::Divergence> missed;
  for (std::uint32_t step = 0; step <= 8; ++step) {
    missed.push_back(divergence(3, step));
  }
  late.add(divergence(3, 8));
  late.add(divergence(3, 9));  // meanwhile
  late.recall(missed);
  ASSERT_EQ(late.current().points.size(), 10U);
  for (std::size_t step = 0; step <= 9; ++step) {
    EXPECT_DOUBLE_EQ(late.current().points[step].time, pusht::kControlStep * static_cast<double>(step));
  }
  EXPECT_DOUBLE_EQ(late.cursor(), 0.9);
  late.add(divergence(4, 0));
  late.recall(missed);
  EXPECT_EQ(late.current().points.size(), 1U) << "an episode that has ended is not the one under way";
  CurveStore empty;
  empty.recall(missed);
  EXPECT_EQ(empty.current().points.size(), 9U);
}

TEST(CurveStore, FindsWhatItKeeps) {
  CurveStore store;
  EXPECT_EQ(store.find(0), nullptr) << "nothing has come";
  store.add(divergence(3, 1));
  store.add(divergence(4, 1));
  ASSERT_NE(store.find(3), nullptr);
  EXPECT_EQ(store.find(3)->episode, 3U);
  EXPECT_EQ(store.find(4), &store.current());
  EXPECT_EQ(store.find(5), nullptr);
}

TEST(CurveStore, CanBeCleared) {
  CurveStore store;
  store.add(divergence(0, 1));
  store.add(divergence(1, 1));
  const std::uint64_t before = store.version();
  store.clear();
  EXPECT_NE(store.version(), before);
  EXPECT_TRUE(store.current().points.empty());
  EXPECT_TRUE(store.earlier().empty());
  EXPECT_EQ(store.end(), 0.0);
}

}  // namespace
}  // namespace pusht_rviz
