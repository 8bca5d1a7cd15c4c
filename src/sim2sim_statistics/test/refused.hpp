// SPDX-License-Identifier: BSD-3-Clause
/// Check that bad input is refused in these words.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <string>

namespace sim2sim {

/// Expects std::domain_error with `message`.
inline void expectRefused(const std::function<void()>& call, const std::string& message) {
  try {
    call();
    ADD_FAILURE() << "not refused: " << message;
  } catch (const std::domain_error& error) {
    EXPECT_EQ(error.what(), message);
  }
}

}  // namespace sim2sim
