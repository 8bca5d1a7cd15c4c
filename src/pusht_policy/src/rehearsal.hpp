// SPDX-License-Identifier: BSD-3-Clause
/// Code that may crash or never return, tried out where that does no harm.
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace pusht {

/// Runs `work` in a copy of this process and throws what it throws: an Error as it is, anything else as InternalError.
/// Throws InvalidInput if the copy crashes, RuntimeFault if it takes longer than `deadline` or if a signal that this
/// process handles arrives meanwhile. `what` begins the message, e.g. "policy FILE". The copy has the calling thread
/// only: `work` may use nothing that another thread may have locked, and nothing that it changes lasts.
void rehearse(const std::string& what, std::chrono::milliseconds deadline, const std::function<void()>& work);

}  // namespace pusht
