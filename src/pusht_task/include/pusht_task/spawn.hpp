// SPDX-License-Identifier: BSD-3-Clause
/// The start of an episode, drawn from a seed exactly as numpy draws it.
#pragma once

#include <cstdint>
#include <pcg_random.hpp>

#include "pusht_task/types.hpp"

namespace pusht {

/// numpy's `Generator(PCG64(seed))`: the same doubles, bit for bit.
/// Sources: M. O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms
/// for Random Number Generation" (2014), and her "Developing a seed_seq Alternative" (2015).
class NumpyGenerator {
 public:
  explicit NumpyGenerator(std::uint64_t seed);

  /// The next double in [0, 1).
  double random();
  /// The next double in [low, high).
  double uniform(double low, double high);

 private:
  pcg64 engine_;
};

/// Tee on a ring around the target with any yaw, pusher clear of it, everything at rest.
WorldState spawn(std::uint64_t seed);

}  // namespace pusht
