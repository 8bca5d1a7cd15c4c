// SPDX-License-Identifier: BSD-3-Clause
/// Background task queue at idle priority.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace sim2sim {

/// Runs tasks in order, in a thread of its own that the scheduler runs only when the machine is idle (SCHED_IDLE). The
/// thread polls every 20 ms, because waking it costs the caller more than a typical task. A caller that waits runs the
/// queued tasks itself, so a busy machine cannot starve it. After a task that throws, later tasks are dropped.
///
/// Any thread may call post() and wait().
class BackgroundQueue {
 public:
  BackgroundQueue();
  BackgroundQueue(const BackgroundQueue&) = delete;
  BackgroundQueue& operator=(const BackgroundQueue&) = delete;
  /// Runs the tasks that are left.
  ~BackgroundQueue();

  /// Queues `task`. Runs all queued tasks in this thread if there are more than 2000. Rethrows the exception of a task.
  void post(std::function<void()> task);

  /// Runs the tasks that are left, in this thread. Rethrows the exception of a task.
  void wait();

 private:
  void work();
  bool runNext();

  std::mutex queue_mutex_;
  std::condition_variable ending_changed_;
  std::deque<std::function<void()>> tasks_;
  bool ending_ = false;

  std::mutex running_;  // held while a task is taken and run, which keeps their order
  std::exception_ptr failure_;
  std::atomic<bool> failed_{false};
  std::thread thread_;
};

}  // namespace sim2sim
