// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_task/spawn.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "pusht_task/constants.hpp"

namespace pusht {
namespace {

/// F20. The draws were made with numpy 1.24: np.random.Generator(np.random.PCG64(seed)).random().
TEST(Spawn, TakesAnySeedOf64Bits) {
  EXPECT_EQ(NumpyGenerator(0).random(), 0.6369616873214543);
  EXPECT_EQ(NumpyGenerator((1ULL << 32U) - 1).random(), 0.2519435680449965);
  EXPECT_EQ(NumpyGenerator(1ULL << 63U).random(), 0.8113443785196867);
  EXPECT_EQ(NumpyGenerator(~0ULL).random(), 0.6800266789616931);
}

/// The draws were made with numpy 1.24, as spawn.hpp says.
TEST(Spawn, NamedStreamsAreNumpysToo) {
  NumpyGenerator noise(0, "action noise");
  EXPECT_EQ(noise.random(), 0.022822596801880146);
  EXPECT_EQ(noise.random(), 0.9162024624247138);
  EXPECT_EQ(NumpyGenerator((1ULL << 40U) + 5, "draw").random(), 0.27765670359553063);
}

TEST(Spawn, KeepsItsBounds) {
  for (std::uint64_t seed = 0; seed < 10000; ++seed) {
    const WorldState state = spawn(seed);
    EXPECT_GE(state.tee_position.norm(), kSpawnRadiusMin - 1e-15);
    EXPECT_LE(state.tee_position.norm(), kSpawnRadiusMax + 1e-15);
    EXPECT_GT((state.pusher_position - state.tee_position).norm(), kSpawnPusherClearance);
    EXPECT_LE(state.pusher_position.cwiseAbs().maxCoeff(), kSpawnPusherBound);
    EXPECT_EQ(wrapAngle(state.tee_yaw), state.tee_yaw);
  }
}

}  // namespace
}  // namespace pusht
