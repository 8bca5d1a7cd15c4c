// SPDX-License-Identifier: BSD-3-Clause
#include "chipmunk_world.hpp"

#include <chipmunk/chipmunk.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <mutex>
#include <utility>

#include "chipmunk_scene.hpp"
#include "pusht_task/substeps.hpp"

namespace pusht {
namespace {

/// Debian's Chipmunk greets on stdout, where results belong, when a process makes its first space.
void greetInSilence() {
  static std::once_flag done;
  std::call_once(done, [] {
    std::fflush(stdout);
    const int out = dup(STDOUT_FILENO);
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    const bool silent = out >= 0 && nowhere >= 0 && dup2(nowhere, STDOUT_FILENO) >= 0;
    const chipmunk::Owned<cpSpace> first(cpSpaceNew());
    std::fflush(stdout);
    if (silent) {
      dup2(out, STDOUT_FILENO);
    }
    for (const int descriptor : {out, nowhere}) {
      if (descriptor >= 0) {
        close(descriptor);
      }
    }
  });
}

}  // namespace

std::string chipmunkVersion() { return cpVersionString; }

ChipmunkWorld::ChipmunkWorld(const ChipmunkParameters& parameters)
    : ChipmunkWorld([parameters] { return std::make_unique<chipmunk::Scene>(parameters); }, parameters.substep) {}

ChipmunkWorld::ChipmunkWorld(MakeScene make_scene, double substep)
    : Simulator("Chipmunk", kStartTolerance),
      make_scene_(std::move(make_scene)),
      substeps_(substepsPerControlStep(substep)) {
  greetInSilence();
  ChipmunkWorld::doReset({});
}

ChipmunkWorld::~ChipmunkWorld() = default;

void ChipmunkWorld::doReset(const WorldState& state) {
  scene_ = make_scene_();
  scene_->start(state);
}

void ChipmunkWorld::doStep(const Action& action) {
  for (int i = 0; i < substeps_; ++i) {
    scene_->substep(cpv(action[0], action[1]));
  }
}

WorldState ChipmunkWorld::doState() const { return scene_->state(); }

}  // namespace pusht
