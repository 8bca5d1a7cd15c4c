// SPDX-License-Identifier: BSD-3-Clause
/// numpy's old generator, from which older environments draw.
#pragma once

#include <cstdint>
#include <optional>
#include <random>

namespace pusht {

/// numpy's `RandomState(seed)`: the same numbers, bit for bit, of the calls that it has.
/// Sources: M. Matsumoto and T. Nishimura, "Mersenne Twister", 1998; G. Marsaglia and T. Bray, "A Convenient Method for
/// Generating Normal Variables", 1964.
class NumpyRandomState {
 public:
  explicit NumpyRandomState(std::uint32_t seed) : engine_(seed) {}

  /// randint(low, high): an integer in [low, high). Throws InvalidInput unless low < high.
  std::int32_t randint(std::int32_t low, std::int32_t high);

  /// randn(): a number of the standard normal distribution.
  double randn();

  /// random_sample(): a double in [0, 1).
  double random();

 private:
  std::mt19937 engine_;
  std::optional<double> spare_;  ///< the second of a pair of normal numbers
};

}  // namespace pusht
