// SPDX-License-Identifier: BSD-3-Clause
/// Pacer: the time at which each control step of a live run may be taken.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>

namespace sim2sim {

/// Pacer of control steps, on the steady clock: rate, pause, single steps. It has no influence on results. Thread-safe:
/// one thread waits in wait(), others control it.
class Pacer {
 public:
  /// Sets the rate [control steps/s]; 0: as fast as possible. Throws InvalidInput for a rate that is negative or not
  /// finite.
  void setRate(double rate);
  double rate() const;

  void pause();
  void resume();
  /// Lets one control step pass while paused. False, without effect, if not paused.
  bool step();
  bool paused() const;

  /// Blocks until the next control step may be taken. Returns false when `stop` holds, which is called every 50 ms,
  /// with the pacer locked.
  bool wait(const std::function<bool()>& stop);

 private:
  using Clock = std::chrono::steady_clock;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  double rate_ = 0.0;
  bool paused_ = false;
  int steps_granted_ = 0;
  std::optional<Clock::time_point> last_;  // time of the last control step
};

}  // namespace sim2sim
