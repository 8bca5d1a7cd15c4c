// SPDX-License-Identifier: BSD-3-Clause
#include "worker.hpp"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace pusht_rviz {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

/// State shared with the thread, which may outlive the worker.
struct Worker::State {
  Call look;  // used in the thread alone
  Times times;

  std::mutex mutex;  // guards all members below
  std::condition_variable changed;
  std::deque<Call> calls;
  std::optional<Clock::time_point> calling_since;
  bool ending = false;
  bool ended = false;
};

Worker::Worker(Call look, Call interrupt, const Times& times)
    : state_(std::make_shared<State>()), interrupt_(std::move(interrupt)) {
  state_->look = std::move(look);
  state_->times = times;
  thread_ = std::thread([state = state_] { run(state); });
}

Worker::~Worker() {
  std::unique_lock<std::mutex> lock(state_->mutex);
  state_->ending = true;
  state_->changed.notify_all();
  const Clock::time_point begin = Clock::now();
  const auto ended = [this] { return state_->ended; };
  // The wait comes first because roscpp cannot break off a call in its first moments.
  if (!state_->changed.wait_until(lock, begin + state_->times.farewell / 3, ended)) {
    lock.unlock();
    interrupt_();
    lock.lock();
  }
  const bool joinable = state_->changed.wait_until(lock, begin + state_->times.farewell, ended);
  lock.unlock();
  if (joinable) {
    thread_.join();
  } else {
    thread_.detach();
  }
}

void Worker::ask(Call call) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->calls.push_back(std::move(call));
  state_->changed.notify_all();
}

void Worker::attend() {
  // With the lock, so that no later call is interrupted in place of the one that is overdue.
  const std::lock_guard<std::mutex> lock(state_->mutex);
  if (state_->calling_since && Clock::now() - *state_->calling_since >= state_->times.deadline) {
    interrupt_();
  }
}

void Worker::run(const std::shared_ptr<State>& state) {
  std::unique_lock<std::mutex> lock(state->mutex);
  while (!state->ending) {
    Call call = state->look;
    if (!state->calls.empty()) {
      call = std::move(state->calls.front());
      state->calls.pop_front();
    }
    state->calling_since = Clock::now();
    lock.unlock();
    call();
    call = nullptr;
    lock.lock();
    state->calling_since.reset();
    state->changed.wait_for(lock, state->times.period, [&] { return state->ending || !state->calls.empty(); });
  }
  std::deque<Call> dropped = std::move(state->calls);
  lock.unlock();
  dropped.clear();
  state->look = nullptr;
  lock.lock();
  state->ended = true;
  state->changed.notify_all();
}

}  // namespace pusht_rviz
