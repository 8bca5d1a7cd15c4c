// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fcntl.h>
#include <unistd.h>

namespace pusht {

/// Opens /dev/null for each standard stream that was closed when the program began. Otherwise the first files of the
/// program would get the descriptors 0 to 2, and output would be written into them. Must be called first in main().
inline void openStandardStreams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    if (::fcntl(stream, F_GETFD) < 0) {
      [[maybe_unused]] const int opened = ::open("/dev/null", O_RDWR);  // takes the lowest free number: this one
    }
  }
}

}  // namespace pusht
