// SPDX-License-Identifier: BSD-3-Clause
#include "live/pacer.hpp"

#include <algorithm>
#include <cmath>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"

namespace sim2sim {

void Pacer::setRate(double rate) {
  if (!std::isfinite(rate) || rate < 0.0) {
    throw pusht::InvalidInput("rate " + pusht::shortestText(rate) +
                              ": must be finite and >= 0 (control steps per second; 0: as fast as possible)");
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  rate_ = rate;
  changed_.notify_all();
}

double Pacer::rate() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return rate_;
}

void Pacer::pause() {
  const std::lock_guard<std::mutex> lock(mutex_);
  paused_ = true;
  changed_.notify_all();
}

void Pacer::resume() {
  const std::lock_guard<std::mutex> lock(mutex_);
  paused_ = false;
  steps_granted_ = 0;
  changed_.notify_all();
}

bool Pacer::step() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!paused_) {
    return false;
  }
  ++steps_granted_;
  changed_.notify_all();
  return true;
}

bool Pacer::paused() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return paused_;
}

bool Pacer::wait(const std::function<bool()>& stop) {
  using Seconds = std::chrono::duration<double>;
  constexpr std::chrono::milliseconds kStopPeriod{50};
  std::unique_lock<std::mutex> lock(mutex_);
  while (!stop()) {
    const Clock::time_point now = Clock::now();
    if (paused_) {
      if (steps_granted_ > 0) {
        --steps_granted_;
        last_ = now;
        return true;
      }
      changed_.wait_for(lock, kStopPeriod);
      continue;
    }
    if (rate_ == 0.0) {
      return true;
    }
    // Steps are due one period after the last; time that was lost is not made up for.
    const Seconds period(1.0 / rate_);  // in double: that of a tiny rate is beyond what a clock can tell
    const Seconds elapsed = last_ ? Seconds(now - *last_) : period;
    if (elapsed >= period) {
      last_ = now;
      return true;
    }
    changed_.wait_for(lock, std::min(period - elapsed, Seconds(kStopPeriod)));
  }
  return false;
}

}  // namespace sim2sim
