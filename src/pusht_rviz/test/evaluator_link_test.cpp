// SPDX-License-Identifier: BSD-3-Clause
#include "evaluator_link.hpp"

#include <gmock/gmock.h>

namespace pusht_rviz {
namespace {

using namespace std::chrono_literals;
using pusht_msgs::NodeStatus;

TEST(EvaluatorPresence, ComesFromTheTopicAndTheConnection) {
  EXPECT_EQ(evaluatorPresence(std::nullopt, false), NodeStatus::WAITING);
  EXPECT_EQ(evaluatorPresence(std::nullopt, true), NodeStatus::WAITING) << "what was never there is not lost";
  EXPECT_EQ(evaluatorPresence(300ms, false), NodeStatus::ALIVE);
  EXPECT_EQ(evaluatorPresence(300ms, true), NodeStatus::ALIVE) << "it has just come back";
  EXPECT_EQ(evaluatorPresence(1500ms, false), NodeStatus::ALIVE) << "it waits for a node";
  EXPECT_EQ(evaluatorPresence(1500ms, true), NodeStatus::LOST);
  EXPECT_EQ(evaluatorPresence(3s, false), NodeStatus::SILENT);
  EXPECT_EQ(evaluatorPresence(3s, true), NodeStatus::LOST);
}

}  // namespace
}  // namespace pusht_rviz
