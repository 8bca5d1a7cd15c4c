// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_bullet/bullet_world.hpp"

#include <cmath>
#include <utility>

#include "bullet_scene.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {
namespace {

constexpr double kMostTurn = kPi / 4.0;  // [rad] by which Bullet turns a body in a substep at most

}  // namespace

BulletWorld::BulletWorld(const BulletParameters& parameters)
    : BulletWorld([parameters] { return std::make_unique<bullet::Scene>(parameters); }, parameters.substep) {}

BulletWorld::BulletWorld(MakeScene make_scene, double substep)
    : Simulator("Bullet", kStartTolerance),
      make_scene_(std::move(make_scene)),
      substep_(substep),
      substeps_(substepsPerControlStep(substep)) {
  doReset({});
}

BulletWorld::~BulletWorld() = default;

void BulletWorld::doReset(const WorldState& state) {
  if (!(std::abs(state.tee_yaw_rate) * substep_ <= kMostTurn)) {
    throw SimulationFault("Bullet: reset: tee_yaw_rate " + shortestText(state.tee_yaw_rate) +
                          " rad/s: must be within " + significantText(kMostTurn / substep_, 4) +
                          " rad/s: Bullet turns a body by at most pi/4 in a substep");
  }
  scene_ = make_scene_();
  scene_->start(state);
  requireStart(state, scene_->state(), kStartTolerance);
  start_ = state;
}

void BulletWorld::doStep(const Action& action) {
  start_.reset();
  const btVector3 command(action[0], action[1], 0.0);
  for (int i = 0; i < substeps_; ++i) {
    scene_->substep(command);
  }
}

WorldState BulletWorld::doState() const { return start_ ? *start_ : scene_->state(); }

}  // namespace pusht
