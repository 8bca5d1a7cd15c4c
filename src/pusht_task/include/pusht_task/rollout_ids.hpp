// SPDX-License-Identifier: BSD-3-Clause
/// What a caller's rollouts are called at a policy that others may ask, too.
#pragma once

#include <cstdint>
#include <limits>
#include <random>

namespace pusht {

/// Consecutive ids from a random number on, which is never 0: so two callers do not share one.
class RolloutIds {
 public:
  std::uint64_t next() { return next_++; }

 private:
  static std::uint64_t randomNumber() {
    std::random_device source;
    return std::uniform_int_distribution<std::uint64_t>(1, std::numeric_limits<std::int64_t>::max())(source);
  }

  std::uint64_t next_ = randomNumber();
};

}  // namespace pusht
