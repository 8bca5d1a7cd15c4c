// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>

#include "pusht_task/error.hpp"

namespace pusht::testing {

constexpr const char* kNotRefused = "not refused";

/// The message of the error of that kind in which `call` ends; kNotRefused if it ends well.
template <class Kind = InvalidInput>
std::string refusalOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const Kind& refusal) {
    return refusal.what();
  }
  return kNotRefused;
}

}  // namespace pusht::testing
