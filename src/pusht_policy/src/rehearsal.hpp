// SPDX-License-Identifier: BSD-3-Clause
/// Code that may crash or never return, tried out where that does no harm. libtorch does both with some damaged
/// checkpoints, and with too little memory: the command then still says which file, and why, with the right exit code.
#pragma once

#include <chrono>
#include <functional>
#include <string>

#include "pusht_task/error.hpp"

namespace pusht {

/// A copy of the process that ended otherwise than by a return or an exception.
struct CrashedCopy : InvalidInput {
  using InvalidInput::InvalidInput;
};

/// A signal has ended the copy, or is to end this process.
struct InterruptedCopy : RuntimeFault {
  using RuntimeFault::RuntimeFault;
};

/// Runs `work` in a copy of this process and throws what it throws: an Error as it is, anything else by its exit code.
/// Throws CrashedCopy if the copy crashes; RuntimeFault if it takes longer than `deadline`; InterruptedCopy if
/// meanwhile the calling thread or the copy gets a signal to end, or soon after `stop` holds: where there are other
/// threads, such a signal may go to one of them. `what` begins the message, e.g. "policy FILE". The copy has the
/// calling thread only, and nothing that it changes lasts. What another thread has locked at that moment stays locked
/// in it: `work` may use malloc, whose locks glibc's fork() sets free, and what no other thread uses; not roscpp. In a
/// copy it runs `work` where it is.
void rehearse(const std::string& what, std::chrono::milliseconds deadline, const std::function<bool()>& stop,
              const std::function<void()>& work);

}  // namespace pusht
