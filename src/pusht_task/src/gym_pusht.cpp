// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/gym_pusht.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "pusht_task/constants.hpp"
#include "pusht_task/numpy_random_state.hpp"

namespace pusht::gym_pusht {
namespace {

using Eigen::Vector2d;

constexpr double kMiddle = kSide / 2.0;                         // [px] on each axis
constexpr double kBarCenter = kPixelsPerMeter * kTeeHalfWidth;  // [px] from the tee's origin, along its y

Vector2d toTable(const Vector2d& pixels) { return Vector2d(pixels.x(), -pixels.y()) / kPixelsPerMeter; }
Vector2d toPixels(const Vector2d& meters) { return kPixelsPerMeter * Vector2d(meters.x(), -meters.y()); }

/// [px] To a point on the axis of a tee that is turned by `angle`, from its origin.
Vector2d armTo(double point, double angle) { return Eigen::Rotation2Dd(angle) * Vector2d(0.0, point); }

Vector2d perpendicular(const Vector2d& arm) { return {-arm.y(), arm.x()}; }

const Vector2d& middle() {
  static const Vector2d point(kMiddle, kMiddle);
  return point;
}

}  // namespace

WorldState toTable(const State& state, double center_of_gravity) {
  WorldState table;
  table.pusher_position = toTable(Vector2d(state.pusher - middle()));
  table.pusher_velocity = toTable(state.pusher_velocity);
  table.tee_position = toTable(Vector2d(state.tee + armTo(kBarCenter, state.angle) - middle()));
  const Vector2d arm = armTo(kBarCenter - center_of_gravity, state.angle);
  table.tee_velocity = toTable(Vector2d(state.tee_velocity + state.rate * perpendicular(arm)));
  table.tee_yaw = wrapAngle(-state.angle);
  table.tee_yaw_rate = -state.rate;
  return table;
}

State fromTable(const WorldState& table, double center_of_gravity) {
  State state;
  state.angle = -table.tee_yaw;
  state.rate = -table.tee_yaw_rate;
  state.pusher = toPixels(table.pusher_position) + middle();
  state.pusher_velocity = toPixels(table.pusher_velocity);
  state.tee = toPixels(table.tee_position) + middle() - armTo(kBarCenter, state.angle);
  const Vector2d arm = armTo(kBarCenter - center_of_gravity, state.angle);
  state.tee_velocity = toPixels(table.tee_velocity) - state.rate * perpendicular(arm);
  return state;
}

State drawn(std::uint32_t seed) {
  NumpyRandomState random(seed);
  const auto point = [&random](int low, int high) {
    const double x = random.randint(low, high);
    const double y = random.randint(low, high);
    return Vector2d(x, y);
  };
  State state;
  state.pusher = point(50, 450);
  state.tee = point(100, 400);
  state.angle = random.randn() * 2.0 * kPi - kPi;
  return state;
}

Pose target() {
  State state;
  state.tee = middle();
  state.angle = kPi / 4.0;
  const WorldState table = toTable(state);
  return {table.tee_position, table.tee_yaw};
}

double coverage(const WorldState& state) { return coverageOf({state.tee_position, state.tee_yaw}, target()); }

double reward(double coverage) { return std::clamp(coverage / kSuccessCoverage, 0.0, 1.0); }

}  // namespace pusht::gym_pusht
