// SPDX-License-Identifier: BSD-3-Clause
#include "chipmunk_types.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <mutex>

namespace pusht {

void prepareChipmunk() {
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

}  // namespace pusht
