// SPDX-License-Identifier: BSD-3-Clause
#include "bag/background_queue.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <stdexcept>
#include <vector>

namespace sim2sim {
namespace {

constexpr int kMany = 25'000;  // more than are queued at once

TEST(BackgroundQueue, RunsTasksInTheirOrder) {
  std::vector<int> done;
  BackgroundQueue worker;
  for (int i = 0; i < kMany; ++i) {
    worker.post([&done, i] { done.push_back(i); });
  }
  worker.wait();
  std::vector<int> expected(kMany);
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(done, expected);
}

TEST(BackgroundQueue, RunsWhatIsLeftAtItsEnd) {
  int done = 0;
  {
    BackgroundQueue worker;
    for (int i = 0; i < 100; ++i) {
      worker.post([&done] { ++done; });
    }
  }
  EXPECT_EQ(done, 100);
}

TEST(BackgroundQueue, TellsOfAFailureAndDropsTheRest) {
  int done = 0;
  BackgroundQueue worker;
  worker.post([] { throw std::runtime_error("no"); });
  worker.post([&done] { ++done; });
  EXPECT_THROW(worker.wait(), std::runtime_error);
  EXPECT_THROW(worker.post([&done] { ++done; }), std::runtime_error);
  EXPECT_EQ(done, 0);
}

}  // namespace
}  // namespace sim2sim
