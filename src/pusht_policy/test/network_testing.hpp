// SPDX-License-Identifier: BSD-3-Clause
/// What the tests of the networks share.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "pusht_policy/network_policy.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "pusht_task/testing/temporary_folder.hpp"

namespace pusht::testing {

/// Debian's reference BLAS sums in index order, as the kernel does: there, libtorch must give the kernel's bits.
inline bool onReferenceBlas() { return activeBlas().find("/blas/libblas") != std::string::npos; }

inline std::vector<std::uint32_t> bits(Span<const float> values) {
  std::vector<std::uint32_t> bits(values.size());
  std::memcpy(bits.data(), values.data(), values.size() * sizeof(float));
  return bits;
}

inline std::vector<float> randomValues(NumpyGenerator& generator, std::size_t count, double bound) {
  std::vector<float> values(count);
  std::generate(values.begin(), values.end(), [&] { return static_cast<float>(generator.uniform(-bound, bound)); });
  return values;
}

/// Starts of episodes other than those that a policy is tried out with when it is loaded, and observations that no
/// episode shows.
inline std::vector<Observation> observations() {
  constexpr int kSpawns = 40;
  constexpr int kWide = 10;
  std::vector<Observation> observations(kSpawns + kWide);
  for (int i = 0; i < kSpawns; ++i) {
    observations[i] = observe(spawn(20000 + i));
  }
  NumpyGenerator generator(20000);
  for (int i = kSpawns; i < kSpawns + kWide; ++i) {
    const std::vector<float> values = randomValues(generator, std::tuple_size<Observation>::value, 3.0);
    std::copy(values.begin(), values.end(), observations[i].begin());
  }
  return observations;
}

/// The actions for `observations`, `batch` of them at a time.
inline std::vector<Action> act(Policy& policy, const std::vector<Observation>& observations, std::size_t batch = 1) {
  std::vector<Policy::Query> queries(observations.size());
  std::transform(observations.begin(), observations.end(), queries.begin(), [](const Observation& observation) {
    return Policy::Query{observation, nullptr};
  });
  std::vector<Action> actions(observations.size());
  for (std::size_t first = 0; first < queries.size(); first += batch) {
    const std::size_t count = std::min(batch, queries.size() - first);
    policy.act({queries.data() + first, count}, {actions.data() + first, count});
  }
  return actions;
}

template <class Array>
std::vector<float> flatten(const std::vector<Array>& rows) {
  std::vector<float> values;
  for (const Array& row : rows) {
    values.insert(values.end(), row.begin(), row.end());
  }
  return values;
}

/// Equal to `tolerance`, relative where values exceed 1.
inline void expectNear(const std::vector<float>& actual, const std::vector<float>& expected, float tolerance) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    ASSERT_NEAR(actual[i], expected[i], tolerance * std::max(1.0F, std::abs(expected[i]))) << "value " << i;
  }
}

}  // namespace pusht::testing
