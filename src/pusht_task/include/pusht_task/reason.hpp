// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <new>
#include <string>

namespace pusht {

/// Reason of a failure for people, on stderr and in a status. exitCodeOf() is the one for callers.
inline std::string reasonOf(const std::exception& failure) {
  const bool out_of_memory = dynamic_cast<const std::bad_alloc*>(&failure) != nullptr;
  return out_of_memory ? "there is no more memory; ask for fewer threads or episodes" : failure.what();
}

}  // namespace pusht
