// SPDX-License-Identifier: BSD-3-Clause
/// Client of one evaluator: subscriber of its topics, sender of goals.
#pragma once

#include <pusht_msgs/CompareGoal.h>

#include <memory>
#include <string>
#include <thread>

#include "events.hpp"

namespace pusht_rviz {

/// Pushes each message, and what becomes of goals, as an event. Callbacks have a queue and a thread of their own, so
/// that hundreds of messages a second do not slow rviz's loop. Another thread subscribes, since that waits for the
/// master.
class EvaluatorClient {
 public:
  /// `evaluator` is its namespace, e.g. "/sim2sim".
  EvaluatorClient(std::string evaluator, std::shared_ptr<Events> events);
  EvaluatorClient(const EvaluatorClient&) = delete;
  EvaluatorClient& operator=(const EvaluatorClient&) = delete;

  /// Waits for its thread for 0.3 s. A thread that hangs, in a call to the master, is left behind and ends by itself.
  ~EvaluatorClient();

  /// Begins to unsubscribe. To be called before the destructor, as ServiceChannel::end().
  void end();

  /// Sends a goal; a GoalEvent says what becomes of it. False: the action is not served, so nothing was sent.
  bool send(const pusht_msgs::CompareGoal& goal);

 private:
  struct State;
  static void run(const std::shared_ptr<State>& state);

  std::shared_ptr<State> state_;
  std::thread thread_;
};

}  // namespace pusht_rviz
