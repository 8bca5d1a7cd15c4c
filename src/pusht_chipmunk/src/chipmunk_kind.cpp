// SPDX-License-Identifier: BSD-3-Clause
#include "chipmunk_kind.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <mutex>

#include "chipmunk_scene.hpp"
#include "pusht_task/scene_kind.hpp"
#include "pusht_task/simulator_plugin.hpp"

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
    cpSpaceFree(cpSpaceNew());
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

const SimulatorKind& chipmunkKind() {
  static const SimulatorKind kind = kindOfScenes<ChipmunkScene>("chipmunk", cpVersionString, {"libchipmunk.so"},
                                                                greetInSilence, ParameterOrder::kNumbersFirst);
  return kind;
}

}  // namespace pusht

PUSHT_EXPORT_SIMULATOR_KIND(chipmunk, pusht::chipmunkKind);
