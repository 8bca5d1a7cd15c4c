// SPDX-License-Identifier: BSD-3-Clause
#include "box2d_world.hpp"

#include <box2d/box2d.h>

#include <array>
#include <cmath>
#include <mutex>
#include <string>
#include <utility>

#include "box2d_scene.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/library.hpp"
#include "pusht_task/numbers.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {
namespace {

/// Box2D fills a table of contacts at the first contact of a process, without a lock.
void fillTableOfContacts() {
  static std::once_flag done;
  std::call_once(done, [] {
    WorldState touching;
    touching.pusher_position = touching.tee_position;
    box2d::Scene first{Box2dParameters()};
    first.start(touching);
    first.substep({0.0, 0.0});
  });
}

/// Throws SimulationFault unless single precision keeps the kind's tolerance where the bodies are.
void requireReach(const char* when, const WorldState& state) {
  struct Coordinate {
    const char* name;
    double value;
  };
  for (const Coordinate& each :
       std::array{Coordinate{"pusher_x", state.pusher_position.x()}, Coordinate{"pusher_y", state.pusher_position.y()},
                  Coordinate{"tee_x", state.tee_position.x()}, Coordinate{"tee_y", state.tee_position.y()}}) {
    if (!(std::abs(each.value) < Box2dWorld::kReach)) {
      throw SimulationFault("Box2D: " + std::string(when) + ": " + each.name + " " + shortestText(each.value) +
                            " m: must be within " + shortestText(Box2dWorld::kReach) +
                            " m, as Box2D computes in single precision");
    }
  }
}

}  // namespace

std::string box2dVersion() {
  // Its own variable b2_version still says 2.4.0 in 2.4.1; the name of its file is right.
  const std::string version = versionOfLibrary(reinterpret_cast<const void*>(&b2Alloc_Default));
  return !version.empty() ? version
                          : std::to_string(b2_version.major) + "." + std::to_string(b2_version.minor) + "." +
                                std::to_string(b2_version.revision);
}

Box2dWorld::Box2dWorld(const Box2dParameters& parameters)
    : Box2dWorld([parameters] { return std::make_unique<box2d::Scene>(parameters); }, parameters.substep) {}

Box2dWorld::Box2dWorld(MakeScene make_scene, double substep)
    : Simulator("Box2D", kStartTolerance),
      make_scene_(std::move(make_scene)),
      substeps_(substepsPerControlStep(substep)) {
  fillTableOfContacts();
  Box2dWorld::doReset({});
}

Box2dWorld::~Box2dWorld() = default;

void Box2dWorld::doReset(const WorldState& state) {
  requireReach("reset", state);
  start_.reset();
  scene_ = make_scene_();
  scene_->start(state);
  if (const std::string fault = scene_->faultOfSpeed(); !fault.empty()) {
    throw SimulationFault("Box2D: reset: " + fault);
  }
  start_ = scene_->rounded(state);
}

void Box2dWorld::doStep(const Action& action) {
  start_.reset();
  for (int i = 0; i < substeps_; ++i) {
    scene_->substep({action[0], action[1]});
    if (const std::string fault = scene_->faultOfSpeed(); !fault.empty()) {
      throw SimulationFault("Box2D: step: " + fault);
    }
  }
  requireReach("step", scene_->state());
}

WorldState Box2dWorld::doState() const { return start_ ? *start_ : scene_->state(); }

}  // namespace pusht
