// SPDX-License-Identifier: BSD-3-Clause
#include "live/activity.hpp"

#include <limits>
#include <utility>

namespace sim2sim {
namespace {

constexpr std::uint32_t kProgressQueue = 100;  // a subscriber must not miss that a run has begun or ended
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

Activity::Activity(ros::NodeHandle& node, const Pacer& pacer, std::function<void(bool)> on_publish)
    : pacer_(pacer),
      on_publish_(std::move(on_publish)),
      progress_(node.advertise<pusht_msgs::Progress>("progress", kProgressQueue, true)) {}

void Activity::markRequested() {
  const std::lock_guard<std::mutex> lock(mutex_);
  busy_ = true;
  cancelled_ = false;
  failure_.clear();
  activity_ = "beginning";
}

void Activity::waitFor(const std::string& services) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_for_ = services;
  }
  publish();
}

void Activity::begin(int episodes) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    episodes_ = episodes;
    episodes_finished_ = 0;
    seconds_left_.reset();
    ++runs_;
  }
  publish();
}

void Activity::finishEpisode(const std::string& progress, double seconds_left) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    activity_ = progress + " finished";
    ++episodes_finished_;
    seconds_left_ = seconds_left;
  }
  publish();
}

bool Activity::end(const std::string& failure) {
  bool cancelled = false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    cancelled = cancelled_;
    busy_ = false;  // before the result, on which the next goal may follow
    failure_ = failure;
    activity_ = "idle";
    waiting_for_.clear();
  }
  publish();
  return cancelled;
}

bool Activity::cancel() {
  const std::lock_guard<std::mutex> lock(mutex_);
  cancelled_ = cancelled_ || busy_;
  return busy_;
}

bool Activity::busy() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return busy_;
}

bool Activity::cancelled() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return cancelled_;
}

void Activity::publish() {
  const std::lock_guard<std::mutex> publishing(publishing_);
  pusht_msgs::Progress progress;
  progress.paused = static_cast<std::uint8_t>(pacer_.paused());
  progress.rate = pacer_.rate();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    progress.busy = static_cast<std::uint8_t>(busy_);
    progress.episodes = static_cast<std::uint32_t>(episodes_);
    progress.episodes_finished = static_cast<std::uint32_t>(episodes_finished_);
    progress.seconds_left = busy_ ? seconds_left_.value_or(kNan) : kNan;
    progress.failure = failure_;
    progress.run = runs_;
    progress.waiting_for = waiting_for_;
  }
  progress_.publish(progress);
  on_publish_(progress.paused != 0);
}

void Activity::report(pusht::DiagnosticStatusWrapper& status) const {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool well = failure_.empty();
    status.summary(well ? diagnostic_msgs::DiagnosticStatus::OK : diagnostic_msgs::DiagnosticStatus::WARN,
                   well ? activity_ : activity_ + "; the last run failed: " + failure_);
  }
  // Outside the lock, because the pacer calls `stop` under its own lock.
  status.add("paused", pacer_.paused());
  status.add("rate [control steps/s]", pacer_.rate());
}

}  // namespace sim2sim
