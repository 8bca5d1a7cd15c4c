// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/gym_pusht.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "pusht_task/constants.hpp"
#include "pusht_task/contact.hpp"
#include "pusht_task/simulator.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"

namespace pusht::gym_pusht {
namespace {

using Eigen::Vector2d;

/// [px] Vector to a point of the axis of a tee that is turned by `angle`.
Vector2d armTo(double point, double angle) { return Eigen::Rotation2Dd(angle) * Vector2d(0.0, point); }

Vector2d perpendicular(const Vector2d& arm) { return {-arm.y(), arm.x()}; }

/// Points of the tee, from its origin, where it is; in gym-pusht's order of operations.
template <std::size_t kCount>
std::array<Vector2d, kCount> placed(const std::array<std::array<double, 2>, kCount>& points, const State& state) {
  const double cosine = std::cos(state.angle);
  const double sine = std::sin(state.angle);
  std::array<Vector2d, kCount> placed;
  std::transform(points.begin(), points.end(), placed.begin(), [&](const std::array<double, 2>& point) {
    const auto [x, y] = point;
    return Vector2d(x * cosine - y * sine + state.tee.x(), x * sine + y * cosine + state.tee.y());
  });
  return placed;
}

class InPixels final : public World {
 public:
  explicit InPixels(std::unique_ptr<Simulator> simulator) : simulator_(std::move(simulator)) {}

  void reset(const State& asked) override {
    const State start = turned(asked);
    simulator_->reset(toTable(start));
    unwrapped_ = start.angle;
  }

  void step(const Vector2d& target) override {
    simulator_->step({static_cast<float>(target.x()), static_cast<float>(target.y())});
    unwrapped_ += wrapAngle(state().angle - unwrapped_);
  }

  State state() const override { return fromTable(simulator_->state()); }

  double unwrappedAngle() const override { return unwrapped_; }

  int contacts() const override { return contactsOf(simulator_->state(), gymPusht()).part() != Part::kNone ? 1 : 0; }

 private:
  std::unique_ptr<Simulator> simulator_;
  double unwrapped_ = 0.0;  // [rad]
};

}  // namespace

WorldState toTable(const State& state, double center_of_gravity) {
  const TaskFrame& frame = gymPusht().frame;
  const Pose tee = frame.poseToTable({state.tee, state.angle});
  const Vector2d arm = armTo(kBarCenter - center_of_gravity, state.angle);
  WorldState table;
  table.pusher_position = frame.pointToTable(state.pusher);
  table.pusher_velocity = frame.vectorToTable(state.pusher_velocity);
  table.tee_position = tee.position;
  table.tee_velocity = frame.vectorToTable(state.tee_velocity + state.rate * perpendicular(arm));
  table.tee_yaw = tee.yaw;
  table.tee_yaw_rate = -state.rate;
  return table;
}

State fromTable(const WorldState& table, double center_of_gravity) {
  const TaskFrame& frame = gymPusht().frame;
  const Pose tee = frame.poseFromTable({table.tee_position, table.tee_yaw});
  const Vector2d arm = armTo(kBarCenter - center_of_gravity, tee.yaw);
  State state;
  state.pusher = frame.pointFromTable(table.pusher_position);
  state.pusher_velocity = frame.vectorFromTable(table.pusher_velocity);
  state.tee = tee.position;
  state.angle = tee.yaw;
  state.rate = -table.tee_yaw_rate;
  state.tee_velocity = frame.vectorFromTable(table.tee_velocity) - state.rate * perpendicular(arm);
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

State turned(const State& asked, double center_of_gravity) {
  State state = asked;
  state.tee = asked.tee + Vector2d(0.0, center_of_gravity) - armTo(center_of_gravity, asked.angle);
  return state;
}

std::array<Vector2d, kCorners> keypoints(const State& state) {
  // Chipmunk's order of the corners.
  return placed<kCorners>({{{-60, 0}, {60, 0}, {60, 30}, {-60, 30}, {-15, 30}, {15, 30}, {15, 120}, {-15, 120}}},
                          state);
}

std::array<Vector2d, kScattered> scatteredKeypoints(const State& state) {
  return placed<kScattered>({{{9.269786713763871, 90.04097352393619},
                              {-60.983472364471474, -1.1867297607997276},
                              {60.91275557727772, -1.3933642242328201},
                              {-0.2705034390160016, 25.54362499146542},
                              {-14.064927576212233, 122.81585355412153},
                              {39.002738500170146, 32.857404276587566},
                              {-39.966414424694534, 32.729655446429945},
                              {-16.82434437939744, 62.86317892234989},
                              {23.54146122024909, -1.7002881094626152}}},
                            state);
}

std::unique_ptr<World> inPixels(std::unique_ptr<Simulator> simulator) {
  return std::make_unique<InPixels>(std::move(simulator));
}

}  // namespace pusht::gym_pusht
