// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_eval/worker.hpp"

#include <chrono>
#include <cstddef>
#include <utility>

namespace sim2sim {
namespace {

constexpr std::chrono::milliseconds kPause(20);
constexpr std::size_t kMaxQueued = 10'000;  // a disk that is too slow slows the run down, instead of filling memory

}  // namespace

Worker::Worker() : thread_([this] { work(); }) {}

Worker::~Worker() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Worker::post(std::function<void()> task) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (tasks_.size() >= kMaxQueued || failure_) {
    waitUntilDone(lock);
  }
  tasks_.push_back(std::move(task));
}

void Worker::wait() {
  std::unique_lock<std::mutex> lock(mutex_);
  waitUntilDone(lock);
}

void Worker::waitUntilDone(std::unique_lock<std::mutex>& lock) {
  awaited_ = true;
  changed_.notify_all();
  changed_.wait(lock, [this] { return !awaited_; });
  if (failure_) {
    std::rethrow_exception(failure_);
  }
}

void Worker::work() {
  std::vector<std::function<void()>> batch;
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    if (tasks_.empty()) {
      awaited_ = false;
      changed_.notify_all();
      if (ending_) {
        return;
      }
    }
    changed_.wait_for(lock, kPause, [this] { return awaited_ || ending_; });
    batch.clear();
    batch.swap(tasks_);
    if (failure_) {
      continue;
    }
    lock.unlock();
    std::exception_ptr failure;
    try {
      for (const std::function<void()>& task : batch) {
        task();
      }
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    failure_ = failure;
  }
}

}  // namespace sim2sim
