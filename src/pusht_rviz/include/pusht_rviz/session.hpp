// SPDX-License-Identifier: BSD-3-Clause
/// The topics and the action of one evaluator.
#pragma once

#include <pusht_msgs/CompareGoal.h>

#include <memory>
#include <string>
#include <thread>

#include "pusht_rviz/letters.hpp"

namespace pusht_rviz {

/// Subscribes, and puts into the mailbox what comes. Callbacks have a queue and a thread of their own, so that rviz's
/// loop sees nothing of hundreds of messages a second. To subscribe takes the master, and waits for it: that, too,
/// happens in a thread of its own.
class Session {
 public:
  /// `evaluator` is the namespace, e.g. "/sim2sim".
  Session(std::string evaluator, std::shared_ptr<Post> post);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Waits for its thread for 0.3 s; one that hangs, in a call to the master, is left behind and ends by itself.
  ~Session();

  /// Begins to unsubscribe. Before the destructor, as of a Line.
  void end();

  /// False: nobody serves the action, so nothing was sent. What becomes of the goal is in GoalNews.
  bool send(const pusht_msgs::CompareGoal& goal);

 private:
  struct State;
  static void run(const std::shared_ptr<State>& state);

  std::shared_ptr<State> state_;
  std::thread thread_;
};

}  // namespace pusht_rviz
