// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>

namespace pusht::testing {

/// Bitwise, so that -0.0 is not 0.0. For what has no padding.
template <class T>
bool sameBits(const T& a, const T& b) {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison,cert-exp42-c,cert-flp37-c)
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

}  // namespace pusht::testing
