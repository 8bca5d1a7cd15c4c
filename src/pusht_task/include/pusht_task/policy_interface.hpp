// SPDX-License-Identifier: BSD-3-Clause
/// Interface of a trained policy: which numbers it sees, and so the tasks in which it can act.
#pragma once

#include <string>
#include <vector>

#include "pusht_task/task.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

/// Numbers that a policy sees in a control step, made of an observation of the task. Its actions are the task's.
struct PolicyInterface {
  enum class Name {
    kFullCircle,    ///< the ten numbers of an Observation, in the table's frame
    kGymState,      ///< gym-pusht's `state`: pusher x, y, tee x, y [px], its angle in [0, 2 pi) [rad]
    kGymKeypoints,  ///< points of the tee and the pusher's position: x, y [px] of each
  };

  Name name = Name::kFullCircle;
  int keypoints = 0;         ///< of kGymKeypoints: 8, the tee's corners (LeRobot), or 9, those of Diffusion Policy
  bool agent_first = false;  ///< of kGymKeypoints: the pusher's position is in front of the points

  /// How many numbers it sees.
  int numbers() const;

  /// Fills `seen` [numbers()] from an observation of a task that it fits.
  void look(const Observation& observation, Span<float> seen) const;

  /// Whether a policy with it can act in `task`: observations and actions mean there what they mean to it.
  bool fits(const Task& task) const;

  /// "gym_keypoints (8, agent first)".
  std::string text() const;

  bool operator==(const PolicyInterface& other) const;
};

/// Keys of the interfaces, as a description names them, in the order of the enumeration.
const std::vector<std::string>& policyInterfaceNames();

/// Names of the interfaces with which a policy can act in `task`.
std::vector<std::string> policyInterfacesOf(const Task& task);

}  // namespace pusht
