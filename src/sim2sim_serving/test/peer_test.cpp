// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_serving/peer.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <stdexcept>
#include <thread>

#include "sim2sim_serving/remote_simulator.hpp"

namespace pusht {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

constexpr seconds kLong{60};

TEST(Stamps, GrowByAControlStep) {
  StampSource stamps;
  EXPECT_TRUE(stamps.now().isZero());
  for (int step = 1; step <= 1000; ++step) {
    stamps.advance();
    EXPECT_EQ(stamps.now().toNSec(), 100'000'000ULL * static_cast<unsigned>(step));
  }
}

TEST(Stamps, AreRaisedAndNeverGoBack) {
  StampSource stamps;
  stamps.raiseTo(ros::Time(7, 1));
  stamps.advance();
  EXPECT_EQ(stamps.now(), ros::Time(7, 100'000'001));
  stamps.raiseTo(ros::Time(3));
  EXPECT_EQ(stamps.now(), ros::Time(7, 100'000'001));
}

TEST(Watchdogs, LeaveCallsAloneThatReturnInTime) {
  Watchdog watchdog(kLong);
  int calls = 0;
  std::atomic<bool> interrupted{false};
  for (int i = 0; i < 1000; ++i) {
    watchdog.run([&] { ++calls; }, [&] { interrupted = true; });
  }
  EXPECT_EQ(calls, 1000);
  EXPECT_FALSE(interrupted);
}

TEST(Watchdogs, InterruptACallAtTheDeadline) {
  constexpr milliseconds kDeadline{50};
  Watchdog watchdog(kDeadline);
  for (int i = 0; i < 3; ++i) {
    std::promise<std::thread::id> interrupt;
    auto interrupted = interrupt.get_future();
    const auto begin = steady_clock::now();
    watchdog.run([&] { ASSERT_EQ(interrupted.wait_for(kLong), std::future_status::ready); },
                 [&] { interrupt.set_value(std::this_thread::get_id()); });
    EXPECT_GE(steady_clock::now() - begin, kDeadline);
    EXPECT_NE(interrupted.get(), std::this_thread::get_id());
  }
}

TEST(Watchdogs, WaitNoLongerThanTheDeadline) {
  constexpr seconds kDeadline{1};
  constexpr int kMargin = 9;  // a busy machine is late, but not by so much
  Watchdog watchdog(kDeadline);
  std::promise<void> interrupt;
  const auto begin = steady_clock::now();
  watchdog.run([&] { interrupt.get_future().wait_for(kLong); }, [&] { interrupt.set_value(); });
  EXPECT_LT(steady_clock::now() - begin, kMargin * kDeadline);
}

TEST(Watchdogs, InterruptACallOnce) {
  Watchdog watchdog(milliseconds(1));
  std::atomic<int> interrupts{0};
  std::promise<void> first;
  watchdog.run(
      [&] {
        first.get_future().wait();
        std::promise<void>().get_future().wait_for(milliseconds(50));  // many deadlines
      },
      [&] {
        ++interrupts;
        first.set_value();
      });
  EXPECT_EQ(interrupts, 1);
}

TEST(Watchdogs, ForgetACallThatHasReturned) {
  constexpr milliseconds kDeadline{20};
  Watchdog watchdog(kDeadline);
  std::atomic<bool> returned{false};
  std::atomic<bool> late{false};
  watchdog.run([] {}, [&] { late = returned.load(); });  // it may expire before, on a busy machine
  returned = true;
  std::promise<void> interrupt;
  watchdog.run([&] { interrupt.get_future().wait_for(kLong); }, [&] { interrupt.set_value(); });
  EXPECT_FALSE(late);
}

TEST(Watchdogs, EndAtOnce) {
  const auto begin = steady_clock::now();
  { const Watchdog watchdog(kLong); }
  EXPECT_LT(steady_clock::now() - begin, seconds(10));
}

}  // namespace
}  // namespace pusht
