// SPDX-License-Identifier: BSD-3-Clause
#include "live/pacer.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <future>
#include <limits>
#include <thread>

#include "pusht_task/error.hpp"

namespace sim2sim {
namespace {

using std::chrono::duration;
using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

bool never() { return false; }

/// Waits in a thread of its own, as a run does.
std::future<bool> waiting(Pacer& pacer, const std::function<bool()>& stop = never) {
  return std::async(std::launch::async, [&pacer, stop] { return pacer.wait(stop); });
}

bool ready(const std::future<bool>& wait, milliseconds patience) {
  return wait.wait_for(patience) == std::future_status::ready;
}

constexpr seconds kLong{60};
constexpr milliseconds kMoment{120};  // longer than a stop is left unnoticed

TEST(Pacers, DoNotWaitAtRateZero) {
  Pacer pacer;
  const auto begin = steady_clock::now();
  for (int step = 0; step < 100'000; ++step) {
    ASSERT_TRUE(pacer.wait(never));
  }
  EXPECT_LT(steady_clock::now() - begin, kLong);
}

TEST(Pacers, KeepTheRate) {
  Pacer pacer;
  pacer.setRate(200.0);
  ASSERT_TRUE(pacer.wait(never));
  const auto begin = steady_clock::now();
  for (int step = 0; step < 20; ++step) {
    ASSERT_TRUE(pacer.wait(never));
  }
  EXPECT_GE(duration<double>(steady_clock::now() - begin).count(), 20 / 200.0 - 1e-3);
}

TEST(Pacers, TakeTheFirstStepAtOnce) {
  Pacer pacer;
  pacer.setRate(1e-9);
  EXPECT_TRUE(ready(waiting(pacer), kLong));
}

TEST(Pacers, TakeANewRateWhileTheyWait) {
  Pacer pacer;
  pacer.setRate(1e-3);  // the second step would be due in 1000 s
  ASSERT_TRUE(pacer.wait(never));
  const auto second = waiting(pacer);
  pacer.setRate(0.0);
  EXPECT_TRUE(ready(second, kLong));
}

TEST(Pacers, LetNothingThroughWhilePaused) {
  Pacer pacer;
  pacer.pause();
  EXPECT_TRUE(pacer.paused());
  auto step = waiting(pacer);
  EXPECT_FALSE(ready(step, kMoment));
  pacer.resume();
  EXPECT_FALSE(pacer.paused());
  EXPECT_TRUE(step.get());
}

TEST(Pacers, LetThroughWhatIsGranted) {
  Pacer pacer;
  EXPECT_FALSE(pacer.step()) << "not paused";
  pacer.pause();
  EXPECT_TRUE(pacer.step());
  EXPECT_TRUE(pacer.step());
  EXPECT_TRUE(pacer.wait(never));
  EXPECT_TRUE(pacer.wait(never));
  auto third = waiting(pacer);
  EXPECT_FALSE(ready(third, kMoment));
  EXPECT_TRUE(pacer.step());
  EXPECT_TRUE(third.get());
}

TEST(Pacers, ForgetWhatWasGrantedWhenTheyResume) {
  Pacer pacer;
  pacer.pause();
  pacer.step();
  pacer.resume();
  pacer.pause();
  std::atomic<bool> stopped{false};
  auto step = waiting(pacer, [&] { return stopped.load(); });
  EXPECT_FALSE(ready(step, kMoment));
  stopped = true;
  EXPECT_FALSE(step.get());
}

TEST(Pacers, StopWhateverTheyWaitFor) {
  for (const bool paused : {false, true}) {
    Pacer pacer;
    pacer.setRate(1e-3);
    pacer.wait(never);
    if (paused) {
      pacer.pause();
    }
    std::atomic<bool> stopped{false};
    auto step = waiting(pacer, [&] { return stopped.load(); });
    stopped = true;
    ASSERT_TRUE(ready(step, kLong));
    EXPECT_FALSE(step.get());
  }
  Pacer pacer;
  EXPECT_FALSE(pacer.wait([] { return true; })) << "even if it need not wait";
}

TEST(Pacers, RefuseRatesThatAreNone) {
  Pacer pacer;
  pacer.setRate(7.0);
  for (const double rate : {-1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    EXPECT_THROW(pacer.setRate(rate), pusht::InvalidInput);
  }
  EXPECT_EQ(pacer.rate(), 7.0);
}

TEST(Pacers, TakeTinyRatesForAPause) {
  Pacer pacer;
  pacer.setRate(std::numeric_limits<double>::min());
  ASSERT_TRUE(pacer.wait(never));
  std::atomic<bool> stopped{false};
  auto step = waiting(pacer, [&] { return stopped.load(); });
  EXPECT_FALSE(ready(step, kMoment));
  stopped = true;
  EXPECT_FALSE(step.get());
}

}  // namespace
}  // namespace sim2sim
