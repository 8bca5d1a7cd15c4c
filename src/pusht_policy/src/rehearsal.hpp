// SPDX-License-Identifier: BSD-3-Clause
/// Rehearsal of code that may crash or never return, in a copy of the process. Faults F28 and F29 (docs/faults.md)
/// depend on it: libtorch crashes or hangs on some damaged checkpoints, and the command must still name the file and
/// the reason, with the right exit code.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "pusht_task/error.hpp"

namespace pusht {

/// Error: the copy ended otherwise than by a return or an exception.
struct CrashedCopy : InvalidInput {
  using InvalidInput::InvalidInput;
};

/// Error: a signal has ended the copy, or is to end this process.
struct InterruptedCopy : RuntimeFault {
  using RuntimeFault::RuntimeFault;
};

/// Runs `work` in a copy of this process (fork) and throws what `work` throws: an Error as it is, any other exception
/// by its exit code. Nothing that the copy changes lasts. Called in a copy, it runs `work` there.
///
/// Throws CrashedCopy if the copy crashes; RuntimeFault if it takes longer than `deadline`; InterruptedCopy if the
/// calling thread or the copy gets a signal to end meanwhile, or within 0.1 s after `stop` holds, because with other
/// threads such a signal may go to one of them. `what` begins the message: "policy FILE".
///
/// The copy has only the calling thread. Locks of other threads stay locked in it: `work` may use malloc, whose locks
/// glibc's fork() releases, and code that no other thread uses, but not roscpp.
void rehearse(const std::string& what, std::chrono::milliseconds deadline, const std::function<bool()>& stop,
              const std::function<void()>& work);

}  // namespace pusht
