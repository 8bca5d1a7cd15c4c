// SPDX-License-Identifier: BSD-3-Clause
/// Initial state of an episode, drawn from a seed with the bits of numpy.
#pragma once

#include <cstdint>
#include <optional>
#include <pcg_random.hpp>
#include <random>
#include <string>

#include "pusht_task/task.hpp"
#include "pusht_task/types.hpp"

namespace pusht {

/// numpy's `Generator(PCG64(seed))`: the same doubles, bit for bit.
/// Sources: M. O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms
/// for Random Number Generation" (2014), and her "Developing a seed_seq Alternative" (2015).
class NumpyGenerator {
 public:
  explicit NumpyGenerator(std::uint64_t seed);

  /// Named stream of a seed: streams of other purposes share no numbers with it, nor does NumpyGenerator(seed). It is
  /// `Generator(PCG64([seed % 2**32, seed >> 32, p % 2**32, p >> 32]))`; p is the first half of the MD5 of `purpose`.
  NumpyGenerator(std::uint64_t seed, const std::string& purpose);

  /// The next double in [0, 1).
  double random();
  /// The next double in [low, high).
  double uniform(double low, double high);

  /// Source of random bits for the distributions of a library, such as boost::random.
  pcg64& bits() { return engine_; }

 private:
  pcg64 engine_;
};

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

/// Initial state for `seed` as the task draws it, all at rest. Throws InvalidInput for a seed beyond the task's last.
WorldState spawn(std::uint64_t seed, const Task& task = fullCircle());

}  // namespace pusht
