// SPDX-License-Identifier: BSD-3-Clause
/// From the threads that talk to ROS to the one that shows.
#pragma once

#include <mutex>
#include <utility>
#include <vector>

namespace pusht_rviz {

/// Letters in the order in which they came. Any thread may put; whoever empties the box never waits for a sender. A
/// thread that hangs and is left behind keeps the box alive, and nobody reads what it puts.
template <class Letter>
class Mailbox {
 public:
  void put(Letter letter) {
    const std::lock_guard<std::mutex> lock(mutex_);
    letters_.push_back(std::move(letter));
  }

  std::vector<Letter> takeAll() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(letters_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<Letter> letters_;
};

}  // namespace pusht_rviz
