// SPDX-License-Identifier: BSD-3-Clause
/// Queue between the threads that talk to ROS and the thread of the GUI.
#pragma once

#include <mutex>
#include <utility>
#include <vector>

namespace pusht_rviz {

/// Events in the order in which they were pushed. Any thread may push; none waits for another longer than a push takes.
/// Threads share the queue by std::shared_ptr: one that hangs and is left behind may still push into a queue that has
/// no reader.
template <class Event>
class EventQueue {
 public:
  void push(Event event) {
    const std::lock_guard<std::mutex> lock(mutex_);
    events_.push_back(std::move(event));
  }

  std::vector<Event> popAll() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(events_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<Event> events_;
};

}  // namespace pusht_rviz
