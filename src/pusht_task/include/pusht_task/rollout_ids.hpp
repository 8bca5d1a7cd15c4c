// SPDX-License-Identifier: BSD-3-Clause
/// Ids of a caller's rollouts at a policy that several callers share.
#pragma once

#include <cstdint>
#include <limits>
#include <random>

namespace pusht {

/// Consecutive ids from a random number >= 1 on, so two callers practically never share one.
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
