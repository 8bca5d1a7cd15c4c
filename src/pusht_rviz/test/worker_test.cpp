// SPDX-License-Identifier: BSD-3-Clause
#include "worker.hpp"

#include <gmock/gmock.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>

namespace pusht_rviz {
namespace {

using namespace std::chrono_literals;
constexpr auto kDeadline = 20s;  // for what must come

/// Calls that hang until they are interrupted, and what they have done.
class Node {
 public:
  Worker::Call answering(char name) {
    return [this, name] { note(name); };
  }

  /// A call that returns when it is interrupted, or, if it cannot be, when the gate opens.
  Worker::Call hanging(char name, bool can_be_interrupted = true) {
    return [this, name, can_be_interrupted] {
      std::unique_lock<std::mutex> lock(mutex_);
      hangs_ = true;
      changed_.notify_all();
      changed_.wait(lock, [&] { return open_ || (interrupted_ && can_be_interrupted); });
      done_ += name;
      changed_.notify_all();
    };
  }

  Worker::Call interrupt() {
    return [this] {
      const std::lock_guard<std::mutex> lock(mutex_);
      interrupted_ = true;
      changed_.notify_all();
    };
  }

  void open() {
    const std::lock_guard<std::mutex> lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }

  bool waitUntilItHangs() {
    std::unique_lock<std::mutex> lock(mutex_);
    return changed_.wait_for(lock, kDeadline, [this] { return hangs_; });
  }

  /// Attends to the worker until these calls are done; false if they never are.
  bool waitFor(const std::string& done, Worker* worker = nullptr) {
    const auto expiry = std::chrono::steady_clock::now() + kDeadline;
    while (std::chrono::steady_clock::now() < expiry) {
      if (worker != nullptr) {
        worker->attend();
      }
      std::unique_lock<std::mutex> lock(mutex_);
      if (changed_.wait_for(lock, 2ms, [&] { return done_ == done; })) {
        return true;
      }
    }
    return false;
  }

  std::string done() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return done_;
  }

 private:
  void note(char name) {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ += name;
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::string done_;
  bool hangs_ = false;
  bool interrupted_ = false;
  bool open_ = false;
};

/// Quick, but for `deadline`, which a busy machine must not reach by itself.
Worker::Times quick() {
  Worker::Times times;
  times.period = 1ms;
  times.deadline = 200ms;
  times.farewell = 60ms;
  return times;
}

Worker::Call nothing() {
  return [] {};
}

TEST(Worker, MakesCallsInTheirOrder) {
  Node node;
  Worker worker(nothing(), node.interrupt(), quick());
  for (const char name : {'a', 'b', 'c'}) {
    worker.ask(node.answering(name));
  }
  EXPECT_TRUE(node.waitFor("abc"));
}

TEST(Worker, LooksBetweenCalls) {
  Node node;
  Worker worker([&, looks = 0]() mutable { ++looks <= 3 ? node.answering('l')() : void(); }, node.interrupt(), quick());
  EXPECT_TRUE(node.waitFor("lll"));
}

TEST(Worker, InterruptsACallThatHangsAndMakesTheNext) {
  Node node;
  Worker worker(nothing(), node.interrupt(), quick());
  worker.ask(node.hanging('h'));
  worker.ask(node.answering('a'));
  ASSERT_TRUE(node.waitUntilItHangs());
  EXPECT_EQ(node.done(), "");
  EXPECT_TRUE(node.waitFor("ha", &worker)) << "a call after one that hangs";
}

TEST(Worker, EndsThoughACallHangs) {
  Node node;
  Worker::Times patient = quick();
  patient.farewell = 3s;
  const auto shared = std::make_shared<int>(0);
  {
    Worker worker([shared] {}, node.interrupt(), patient);
    worker.ask([shared, hang = node.hanging('h')] { hang(); });
    worker.ask([shared, call = node.answering('a')] { call(); });
    ASSERT_TRUE(node.waitUntilItHangs());
  }
  EXPECT_EQ(node.done(), "h") << "the queue is dropped";
  EXPECT_EQ(shared.use_count(), 1) << "the thread has ended, and released what the calls share";
}

/// Task that hangs as a call to a master would.
TEST(Worker, LeavesBehindWhatCannotBeInterrupted) {
  const auto node = std::make_shared<Node>();
  {
    Worker worker([node] {}, [] {}, quick());
    worker.ask([node, hang = node->hanging('h', false)] { hang(); });
    ASSERT_TRUE(node->waitUntilItHangs());
  }
  EXPECT_EQ(node->done(), "") << "the destructor did not wait for it";
  node->open();
  EXPECT_TRUE(node->waitFor("h"));
}

}  // namespace
}  // namespace pusht_rviz
