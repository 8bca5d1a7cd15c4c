// SPDX-License-Identifier: BSD-3-Clause
/// Work that nobody waits for.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace sim2sim {

/// Runs tasks one after the other in a thread of its own, in the time that all others leave. It looks for them every
/// 20 ms: to be woken for each would cost the caller more than many a task. Who waits for it works himself, so that it
/// does not starve on a busy machine. After a task that throws, the others are dropped.
class BackgroundQueue {
 public:
  BackgroundQueue();
  BackgroundQueue(const BackgroundQueue&) = delete;
  BackgroundQueue& operator=(const BackgroundQueue&) = delete;
  /// Runs what is left.
  ~BackgroundQueue();

  /// Queues `task`; runs what is queued if that is much. Throws what a task has thrown.
  void post(std::function<void()> task);

  /// Runs what is left. Throws what a task has thrown.
  void wait();

 private:
  void work();
  bool runNext();

  std::mutex queue_mutex_;
  std::condition_variable ending_changed_;
  std::deque<std::function<void()>> tasks_;
  bool ending_ = false;

  std::mutex running_;  // held while a task is taken and run: they run in order
  std::exception_ptr failure_;
  std::atomic<bool> failed_{false};
  std::thread thread_;
};

}  // namespace sim2sim
