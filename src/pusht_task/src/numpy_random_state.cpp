// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/numpy_random_state.hpp"

#include <cmath>
#include <string>

#include "pusht_task/error.hpp"

namespace pusht {

std::int32_t NumpyRandomState::randint(std::int32_t low, std::int32_t high) {
  if (low >= high) {
    throw InvalidInput("randint " + std::to_string(low) + ", " + std::to_string(high) +
                       ": the first must be below the second");
  }
  const auto range = static_cast<std::uint32_t>(high) - static_cast<std::uint32_t>(low) - 1U;
  if (range == 0) {
    return low;  // numpy draws nothing
  }
  std::uint32_t mask = range;
  for (const unsigned shift : {1U, 2U, 4U, 8U, 16U}) {
    mask |= mask >> shift;
  }
  std::uint32_t value = 0;
  do {
    value = static_cast<std::uint32_t>(engine_()) & mask;
  } while (value > range);
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(low) + value);
}

double NumpyRandomState::random() {
  const auto high = static_cast<double>(engine_() >> 5U);
  const auto low = static_cast<double>(engine_() >> 6U);
  return (high * 0x1p26 + low) / 0x1p53;
}

double NumpyRandomState::randn() {
  if (spare_) {
    const double spare = *spare_;
    spare_.reset();
    return spare;
  }
  double x = 0.0;
  double y = 0.0;
  double squared = 0.0;
  do {
    x = 2.0 * random() - 1.0;
    y = 2.0 * random() - 1.0;
    squared = x * x + y * y;
  } while (squared >= 1.0 || squared == 0.0);
  const double factor = std::sqrt(-2.0 * std::log(squared) / squared);
  spare_ = factor * x;
  return factor * y;
}

}  // namespace pusht
