// SPDX-License-Identifier: BSD-3-Clause
#include "bullet_world.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "bullet_scene.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {
namespace {

/// Throws SimulationFault if Bullet would turn the tee by less than its rate [rad/s] says.
void requireTurn(const char* when, double yaw_rate, double substep) {
  constexpr double kMostTurn = kPi / 4.0;  // [rad] in a substep
  if (!(std::abs(yaw_rate) * substep <= kMostTurn)) {
    throw SimulationFault("Bullet: " + std::string(when) + ": tee_yaw_rate " + shortestText(yaw_rate) +
                          " rad/s: must be within " + significantText(kMostTurn / substep, 4) +
                          " rad/s: Bullet turns a body by at most pi/4 in a substep");
  }
}

}  // namespace

BulletWorld::BulletWorld(const BulletParameters& parameters)
    : BulletWorld([parameters] { return std::make_unique<bullet::Scene>(parameters); }, parameters.substep) {}

BulletWorld::BulletWorld(MakeScene make_scene, double substep)
    : Simulator("Bullet", kStartTolerance),
      make_scene_(std::move(make_scene)),
      substep_(substep),
      substeps_(substepsPerControlStep(substep)) {
  BulletWorld::doReset({});
}

BulletWorld::~BulletWorld() = default;

void BulletWorld::doReset(const WorldState& state) {
  requireTurn("reset", state.tee_yaw_rate, substep_);
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
    requireTurn("step", scene_->teeYawRate(), substep_);
  }
}

WorldState BulletWorld::doState() const { return start_ ? *start_ : scene_->state(); }

}  // namespace pusht
