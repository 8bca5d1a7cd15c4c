// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/task.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace pusht {
namespace {

/// Box of the tee, in its frame [m].
struct TeePart {
  double center_y;
  double half_x;
  double half_y;
};

constexpr std::array kTeeParts = {TeePart{0.0, kBarHalfLength, kTeeHalfWidth},
                                  TeePart{-kStemOffset, kTeeHalfWidth, kStemHalfLength}};

/// Distance [m] of a point from a box of these half-sizes around the origin; negative within.
double signedDistance(const Eigen::Vector2d& point, const Eigen::Vector2d& half) {
  const Eigen::Vector2d beyond = point.cwiseAbs() - half;
  return beyond.cwiseMax(0.0).norm() + std::min(0.0, beyond.maxCoeff());
}

}  // namespace

Action clip(const Action& action) {
  return {std::clamp(action[0], -kActionLimit, kActionLimit), std::clamp(action[1], -kActionLimit, kActionLimit)};
}

Observation observe(const WorldState& state) {
  constexpr std::array<float, 4> kTarget = {0.0F, 0.0F, 0.0F, 1.0F};  // x, y, sin, cos of the target pose
  return {static_cast<float>(state.pusher_position.x()),
          static_cast<float>(state.pusher_position.y()),
          static_cast<float>(state.tee_position.x()),
          static_cast<float>(state.tee_position.y()),
          static_cast<float>(std::sin(state.tee_yaw)),
          static_cast<float>(std::cos(state.tee_yaw)),
          kTarget[0],
          kTarget[1],
          kTarget[2],
          kTarget[3]};
}

Overlap deepestOverlap(const WorldState& state) {
  const Eigen::Rotation2Dd yaw(state.tee_yaw);
  const Eigen::Vector2d pusher = yaw.inverse() * (state.pusher_position - state.tee_position);
  Overlap deepest{"pusher and walls", state.pusher_position.lpNorm<Eigen::Infinity>() + kPusherRadius - kWallInnerFace};
  const auto take = [&](const char* bodies, double depth) {
    if (depth > deepest.depth) {
      deepest = {bodies, depth};
    }
  };
  for (const TeePart& part : kTeeParts) {
    const Eigen::Vector2d center(0.0, part.center_y);
    const Eigen::Vector2d half(part.half_x, part.half_y);
    take("pusher and tee", kPusherRadius - signedDistance(pusher - center, half));
    for (const double x : {-1.0, 1.0}) {
      for (const double y : {-1.0, 1.0}) {
        const Eigen::Vector2d corner = center + Eigen::Vector2d(x, y).cwiseProduct(half);
        take("tee and walls", (state.tee_position + yaw * corner).lpNorm<Eigen::Infinity>() - kWallInnerFace);
      }
    }
  }
  return deepest;
}

PoseError poseError(const WorldState& state) { return {state.tee_position.norm(), std::abs(wrapAngle(state.tee_yaw))}; }

bool SuccessLatch::update(const PoseError& error) {
  steps_in_tolerance_ = error.inTolerance() ? steps_in_tolerance_ + 1 : 0;
  if (latched_ || steps_in_tolerance_ < kSuccessHold) {
    return false;
  }
  latched_ = true;
  return true;
}

double reward(const PoseError& error, bool just_latched) {
  const double shaping = -0.5 * (error.position / kRewardPositionScale + error.angle / kPi);
  return just_latched ? shaping + kRewardBonus : shaping;
}

}  // namespace pusht
