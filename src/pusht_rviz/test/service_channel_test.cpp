// SPDX-License-Identifier: BSD-3-Clause
#include "service_channel.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <vector>

namespace pusht_rviz {
namespace {

using namespace std::chrono_literals;
constexpr auto kDeadline = 20s;  // for what must come

/// A node that answers, hangs or is gone, and who waits for it.
class FakeNode {
 public:
  enum class Mood { kAnswers, kHangs, kGone };

  void become(Mood mood) {
    const std::lock_guard<std::mutex> lock(mutex_);
    mood_ = mood;
    changed_.notify_all();
  }

  void note(Presence presence) {
    const std::lock_guard<std::mutex> lock(mutex_);
    told_.push_back(presence);
    changed_.notify_all();
  }

  /// Attends to the channel until `presence` was told; false if it never is.
  bool waitFor(ServiceChannel& channel, Presence presence) {
    const auto expiry = std::chrono::steady_clock::now() + kDeadline;
    while (std::chrono::steady_clock::now() < expiry) {
      channel.attend();
      std::unique_lock<std::mutex> lock(mutex_);
      if (changed_.wait_for(lock, 2ms, [&] { return !told_.empty() && told_.back() == presence; })) {
        return true;
      }
    }
    return false;
  }

  std::vector<Presence> told() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return told_;
  }

  bool gone() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return mood_ == Mood::kGone;
  }

  /// Returns when the node answers or dies, or `closed` holds.
  bool call(const std::atomic<bool>& closed) {
    std::unique_lock<std::mutex> lock(mutex_);
    while (mood_ == Mood::kHangs && !closed) {
      changed_.wait_for(lock, 1ms);
    }
    return mood_ == Mood::kAnswers && !closed;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  Mood mood_ = Mood::kAnswers;
  std::vector<Presence> told_;
};

class ToNode : public Connection {
 public:
  explicit ToNode(std::shared_ptr<FakeNode> node) : node_(std::move(node)) {}
  bool stands() const override { return !closed_ && !node_->gone(); }
  void close() override { closed_ = true; }
  bool call() { return node_->call(closed_); }

 private:
  std::shared_ptr<FakeNode> node_;
  std::atomic<bool> closed_ = false;
};

/// Quick, but for `silence` and `deadline`, which a busy machine must not reach by itself.
ServiceChannel::Times quick() {
  ServiceChannel::Times times;
  times.tick = 1ms;
  times.heartbeat = 5ms;
  times.retry = 5ms;
  times.silence = 200ms;
  times.deadline = 400ms;
  times.farewell = 60ms;
  return times;
}

std::unique_ptr<ServiceChannel> channelTo(const std::shared_ptr<FakeNode>& node,
                                          const ServiceChannel::Times& times = quick()) {
  return std::make_unique<ServiceChannel>(
      [node] { return std::make_shared<ToNode>(node); },
      [](Connection& connection) { return static_cast<ToNode&>(connection).call(); },
      [node](Presence presence) { node->note(presence); }, times);
}

TEST(ServiceChannel, TellsOfANodeThatComesDiesAndComesBack) {
  const auto node = std::make_shared<FakeNode>();
  node->become(FakeNode::Mood::kGone);
  const auto channel = channelTo(node);
  node->become(FakeNode::Mood::kAnswers);
  EXPECT_TRUE(node->waitFor(*channel, Presence::kAlive));
  node->become(FakeNode::Mood::kGone);
  EXPECT_TRUE(node->waitFor(*channel, Presence::kLost));
  node->become(FakeNode::Mood::kAnswers);
  EXPECT_TRUE(node->waitFor(*channel, Presence::kAlive));
  EXPECT_THAT(node->told(), testing::ElementsAre(Presence::kAlive, Presence::kLost, Presence::kAlive));
}

TEST(ServiceChannel, TellsOfANodeThatHangsAndGoesOn) {
  const auto node = std::make_shared<FakeNode>();
  const auto channel = channelTo(node);
  ASSERT_TRUE(node->waitFor(*channel, Presence::kAlive));
  node->become(FakeNode::Mood::kHangs);
  EXPECT_TRUE(node->waitFor(*channel, Presence::kSilent));
  node->become(FakeNode::Mood::kAnswers);
  EXPECT_TRUE(node->waitFor(*channel, Presence::kAlive));
  EXPECT_THAT(node->told(), testing::ElementsAre(Presence::kAlive, Presence::kSilent, Presence::kAlive));
}

TEST(ServiceChannel, ACallThatHangsIsBrokenOffAndTheNodeStaysSilent) {
  const auto node = std::make_shared<FakeNode>();
  const auto channel = channelTo(node);
  ASSERT_TRUE(node->waitFor(*channel, Presence::kAlive));
  node->become(FakeNode::Mood::kHangs);
  ASSERT_TRUE(node->waitFor(*channel, Presence::kSilent));
  std::atomic<int> answers = 0;
  channel->ask([&](Connection& connection) {
    const bool answered = static_cast<ToNode&>(connection).call();
    answers += answered ? 0 : 1;
    return answered;
  });
  const auto expiry = std::chrono::steady_clock::now() + kDeadline;
  while (answers == 0 && std::chrono::steady_clock::now() < expiry) {
    channel->attend();
  }
  EXPECT_EQ(answers, 1) << "who asks a node that hangs gets to know that there is no answer";
  EXPECT_EQ(node->told().back(), Presence::kSilent);
  node->become(FakeNode::Mood::kGone);
  EXPECT_TRUE(node->waitFor(*channel, Presence::kLost));
}

TEST(ServiceChannel, WithoutANodeFailsAtOnce) {
  const auto node = std::make_shared<FakeNode>();
  node->become(FakeNode::Mood::kGone);
  const auto channel = channelTo(node);
  std::mutex mutex;
  std::condition_variable changed;
  bool failed = false;
  channel->ask([&](Connection& connection) {
    const bool answered = static_cast<ToNode&>(connection).call();
    const std::lock_guard<std::mutex> lock(mutex);
    failed = !answered;
    changed.notify_all();
    return answered;
  });
  std::unique_lock<std::mutex> lock(mutex);
  EXPECT_TRUE(changed.wait_for(lock, kDeadline, [&] { return failed; }));
  EXPECT_THAT(node->told(), testing::IsEmpty()) << "who was never there is not lost";
}

TEST(ServiceChannel, EndsThoughTheNodeHangs) {
  const auto node = std::make_shared<FakeNode>();
  ServiceChannel::Times patient = quick();
  patient.farewell = 3s;
  auto channel = channelTo(node, patient);
  ASSERT_TRUE(node->waitFor(*channel, Presence::kAlive));
  node->become(FakeNode::Mood::kHangs);
  ASSERT_TRUE(node->waitFor(*channel, Presence::kSilent));
  channel.reset();
  EXPECT_EQ(node.use_count(), 1) << "the thread has ended, too";
}

/// A call that cannot be broken off, as one to a master that hangs.
TEST(ServiceChannel, LeavesBehindWhatCannotBeBrokenOff) {
  struct Gate {
    std::mutex mutex;
    std::condition_variable changed;
    bool inside = false;
    bool open = false;
    bool left = false;
  };
  const auto gate = std::make_shared<Gate>();
  const auto node = std::make_shared<FakeNode>();
  auto channel = std::make_unique<ServiceChannel>([node] { return std::make_shared<ToNode>(node); },
                                                  [gate](Connection& /*connection*/) {
                                                    std::unique_lock<std::mutex> lock(gate->mutex);
                                                    gate->inside = true;
                                                    gate->changed.notify_all();
                                                    gate->changed.wait(lock, [&] { return gate->open; });
                                                    gate->left = true;
                                                    gate->changed.notify_all();
                                                    return true;
                                                  },
                                                  [node](Presence presence) { node->note(presence); }, quick());
  std::unique_lock<std::mutex> lock(gate->mutex);
  ASSERT_TRUE(gate->changed.wait_for(lock, kDeadline, [&] { return gate->inside; }));
  lock.unlock();
  channel.reset();
  lock.lock();
  EXPECT_FALSE(gate->left) << "the destructor did not wait for it";
  gate->open = true;
  gate->changed.notify_all();
  EXPECT_TRUE(gate->changed.wait_for(lock, kDeadline, [&] { return gate->left; }));
  EXPECT_THAT(node->told(), testing::IsEmpty()) << "and the owner is told no more";
}

}  // namespace
}  // namespace pusht_rviz
