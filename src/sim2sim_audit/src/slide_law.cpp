// SPDX-License-Identifier: BSD-3-Clause
#include "slide_law.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "pusht_task/constants.hpp"

namespace sim2sim {

using pusht::WorldState;

std::optional<SlideLaw> slideLaw(Bench& bench, const Eigen::Vector2d& direction) {
  const double from = 0.28 - bench.narrower();           // [m] of the start behind the middle
  const double longest = 0.59 - 2.0 * bench.narrower();  // [m] so that no corner reaches a wall
  const bool has_friction = bench.physics().tee_friction[0] > 0.0;
  const double sliding = has_friction ? 0.3 : 0.03;  // [m/s] below which friction may be at rest
  std::vector<Eigen::Vector3d> rows;                 // distance [m], time [s], lost velocity [m/s]
  for (const double speed : {24.0, 21.0, 18.0, 5.0, 4.0, 3.0, 2.0, 1.7}) {
    WorldState start;
    start.tee_position = bench.shift() - from * direction;
    start.tee_velocity = speed * direction;
    start.tee_yaw = pusht::wrapAngle(std::atan2(direction.y(), direction.x()) - 0.5 * pusht::kPi);
    start.pusher_position = (0.3 - bench.narrower()) * Eigen::Vector2d(-direction.y(), direction.x());
    const auto states = bench.run(start, {{0.0, 0.0}});
    const double distance = (states[1].tee_position - states[0].tee_position).dot(direction);
    const double left = states[1].tee_velocity.dot(direction);
    if (distance < longest && left > sliding) {
      rows.emplace_back(distance, pusht::kControlStep, speed - left);
    }
  }
  if (rows.size() < 2) {
    return std::nullopt;
  }
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(rows.size()), 2);
  Eigen::VectorXd losses(columns.rows());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    columns.row(static_cast<Eigen::Index>(i)) = rows[i].head<2>();
    losses[static_cast<Eigen::Index>(i)] = rows[i][2];
  }
  const Eigen::Vector2d law = columns.colPivHouseholderQr().solve(losses);
  return SlideLaw{law[0], law[1], (columns * law - losses).norm() / std::sqrt(static_cast<double>(rows.size()))};
}

SlideLaws slideLaws(Bench& bench) {
  const double askew = std::sqrt(0.5);
  return {slideLaw(bench, {1.0, 0.0}), slideLaw(bench, {0.0, 1.0}), slideLaw(bench, {askew, askew})};
}

std::optional<double> shapeOf(const SlideLaws& slides) {
  if (!slides[0] || !slides[1] || !slides[2]) {
    return std::nullopt;
  }
  const double along_axes = 0.5 * (slides[0]->friction + slides[1]->friction);
  constexpr double kNone = 0.3;  // [m/s^2] a fortieth of the task's
  return along_axes > kNone ? std::optional(slides[2]->friction / along_axes) : std::nullopt;
}

}  // namespace sim2sim
