// SPDX-License-Identifier: BSD-3-Clause
/// Work that nobody waits for.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace sim2sim {

/// Runs tasks one after the other in a thread of its own, which looks for them every 20 ms: to be woken for each would
/// cost the caller more than many a task. After one that throws, the others are dropped.
class Worker {
 public:
  Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  /// Runs what is left.
  ~Worker();

  /// Queues `task`; waits while very many are queued. Throws what a task has thrown.
  void post(std::function<void()> task);

  /// Waits until everything is done. Throws what a task has thrown.
  void wait();

 private:
  void waitUntilDone(std::unique_lock<std::mutex>& lock);
  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::function<void()>> tasks_;
  std::exception_ptr failure_;
  bool awaited_ = false;  // someone waits until everything is done
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace sim2sim
