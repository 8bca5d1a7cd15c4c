// SPDX-License-Identifier: BSD-3-Clause
#include "bag/background_queue.hpp"

#include <sched.h>

#include <chrono>
#include <cstddef>
#include <utility>

namespace sim2sim {
namespace {

constexpr std::chrono::milliseconds kPause(20);
constexpr std::size_t kMuch = 2'000;  // tasks

}  // namespace

BackgroundQueue::BackgroundQueue() : thread_([this] { work(); }) {}

BackgroundQueue::~BackgroundQueue() {
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    ending_ = true;
  }
  ending_changed_.notify_one();
  while (runNext()) {
  }
  thread_.join();
}

void BackgroundQueue::post(std::function<void()> task) {
  std::size_t queued = 0;
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    tasks_.push_back(std::move(task));
    queued = tasks_.size();
  }
  if (queued > kMuch || failed_) {
    wait();
  }
}

void BackgroundQueue::wait() {
  while (runNext()) {
  }
  const std::lock_guard<std::mutex> lock(running_);
  if (failure_) {
    std::rethrow_exception(failure_);
  }
}

void BackgroundQueue::work() {
  const sched_param none{};
  sched_setscheduler(0, SCHED_IDLE, &none);  // of this thread
  std::unique_lock<std::mutex> lock(queue_mutex_);
  while (!ending_) {
    ending_changed_.wait_for(lock, kPause);
    lock.unlock();
    while (runNext()) {
    }
    lock.lock();
  }
}

/// False if there is no task.
bool BackgroundQueue::runNext() {
  const std::lock_guard<std::mutex> run(running_);
  std::function<void()> task;
  {
    const std::lock_guard<std::mutex> lock(queue_mutex_);
    if (tasks_.empty()) {
      return false;
    }
    task = std::move(tasks_.front());
    tasks_.pop_front();
  }
  try {
    if (!failed_) {
      task();
    }
  } catch (...) {
    failure_ = std::current_exception();
    failed_ = true;
  }
  return true;
}

}  // namespace sim2sim
