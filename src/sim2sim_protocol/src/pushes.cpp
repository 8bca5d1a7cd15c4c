// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/pushes.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "pusht_task/task.hpp"

namespace sim2sim {
namespace {

/// Center of mass of the tee [m] in the table frame.
Eigen::Vector2d centerOf(const pusht::WorldState& state, const pusht::Task& task) {
  return state.tee_position +
         task.physics.centerOfMass() * Eigen::Vector2d(std::sin(state.tee_yaw), -std::cos(state.tee_yaw));
}

/// [m] Radius of gyration of a task's tee about its center of mass.
double gyrationOf(const pusht::Task& task) {
  const pusht::Physics& physics = task.physics;
  const double center = physics.centerOfMass();
  return &task == &pusht::fullCircle() ? kGyration
                                       : std::sqrt(physics.tee_second_moment / physics.tee_mass - center * center);
}

/// State of the replay at the end of a window: its last one, or that of a success before.
const pusht::WorldState& endOf(const pusht::Trace& replay, std::size_t begin, std::size_t end,
                               const pusht::Task& task) {
  pusht::SuccessLatch latch(task);
  std::size_t k = begin + 1;
  while (k < end && !latch.update(replay.states[k])) {
    ++k;
  }
  return replay.states[k];
}

}  // namespace

Eigen::Vector3d teeDisplacement(const pusht::WorldState& a, const pusht::WorldState& b, const pusht::Task& task) {
  const Eigen::Vector2d moved = centerOf(b, task) - centerOf(a, task);
  return {moved.x(), moved.y(), gyrationOf(task) * pusht::wrapAngle(b.tee_yaw - a.tee_yaw)};
}

PushFigures pushFigures(const pusht::Trace& reference, const pusht::Trace& replay, int window,
                        const pusht::Task& task) {
  const auto every = static_cast<std::size_t>(window);
  int pushes = 0;
  int missed = 0;
  int turned = 0;
  double direction_error = 0.0;
  double size = 0.0;
  for (std::size_t end = every; end < std::min(reference.states.size(), replay.states.size()); end += every) {
    const pusht::WorldState& begin = reference.states[end - every];
    const Eigen::Vector3d of_reference = teeDisplacement(begin, reference.states[end], task);
    if (of_reference.norm() <= kLeastPush * window) {
      continue;
    }
    const Eigen::Vector3d of_engine = teeDisplacement(begin, endOf(replay, end - every, end, task), task);
    const double ratio = of_engine.norm() / of_reference.norm();
    const double inner = of_reference.dot(of_engine);
    ++pushes;
    size += std::log(std::clamp(ratio, 1.0 / kLargestPushRatio, kLargestPushRatio));
    if (ratio < kMissedShare) {
      ++missed;
      direction_error += kMissedDirection;
    } else {
      turned += inner < 0.0 ? 1 : 0;
      direction_error += std::acos(std::clamp(inner / (of_reference.norm() * of_engine.norm()), -1.0, 1.0));
    }
  }
  const double count = pushes;  // 0 / 0 is NaN: there is none
  return {pushes, direction_error / count, missed / count, turned / (count - missed), size / count};
}

}  // namespace sim2sim
