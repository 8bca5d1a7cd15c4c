// SPDX-License-Identifier: BSD-3-Clause
/// When the next control step of a live run may be taken.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>

namespace sim2sim {

/// Paced, paused and stepped from one thread, waited for in another; on the steady clock. It decides when a control
/// step is taken, never what comes out.
class Pacer {
 public:
  /// `rate` in control steps per second; 0: as fast as possible. Throws InvalidInput if it is not finite or below 0.
  void setRate(double rate);
  double rate() const;

  void pause();
  void resume();
  /// Lets one control step through. False, and nothing happens, unless paused.
  bool step();
  bool paused() const;

  /// Waits until the next control step may be taken. Returns false as soon as `stop` holds; it is asked every 50 ms.
  bool wait(const std::function<bool()>& stop);

 private:
  using Clock = std::chrono::steady_clock;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  double rate_ = 0.0;
  bool paused_ = false;
  int steps_granted_ = 0;
  std::optional<Clock::time_point> last_;  // when the last control step was let through
};

}  // namespace sim2sim
