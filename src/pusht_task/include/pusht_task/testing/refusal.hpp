// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include "pusht_task/error.hpp"

namespace pusht::testing {

/// The message of the InvalidInput that `call` ends in.
inline std::string refusalOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InvalidInput& refusal) {
    return refusal.what();
  }
  return "not refused";
}

}  // namespace pusht::testing
