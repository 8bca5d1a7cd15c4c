// SPDX-License-Identifier: BSD-3-Clause
/// Thread for what waits: for the master, and for answers.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <thread>
#include <utility>

namespace pusht_rviz {

/// Makes calls one after the other, in a thread of its own; no method waits, except the destructor.
///
/// Between the calls that ask() queues, the thread calls `look`, every Times::period. attend(), in the owner's thread,
/// interrupts a call that is under way for longer than Times::deadline. A mutex guards the queue and the begin of the
/// call under way; calls are made without it, interrupts with it. Calls may outlive the worker, so they share what they
/// use, and release it in the worker's thread.
class Worker {
 public:
  using Call = std::function<void()>;

  /// Period and deadlines.
  struct Times {
    std::chrono::milliseconds period{100};     ///< between calls of `look`
    std::chrono::milliseconds deadline{5000};  ///< duration of a call after which it is interrupted
    std::chrono::milliseconds farewell{300};   ///< longest that the destructor waits for the thread
  };

  /// `interrupt` makes the call under way return; it is called in the owner's thread.
  Worker(Call look, Call interrupt, const Times& times);
  Worker(Call look, Call interrupt) : Worker(std::move(look), std::move(interrupt), Times()) {}
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Drops the queue, interrupts the call under way, and waits for Times::farewell at most. A call that cannot be
  /// interrupted, as one to a master that hangs, is left behind with its thread.
  ~Worker();

  /// Queues a call.
  void ask(Call call);

  /// Interrupts a call that is overdue. To be called often.
  void attend();

 private:
  struct State;
  static void run(const std::shared_ptr<State>& state);

  std::shared_ptr<State> state_;
  Call interrupt_;
  std::thread thread_;
};

}  // namespace pusht_rviz
