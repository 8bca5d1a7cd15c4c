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
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "pusht_policy/network_policy.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_task/task.hpp"
#include "pusht_testing/temporary_folder.hpp"

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

/// These, and random ones: a thousand.
inline std::vector<Observation> manyObservations() {
  constexpr int kMany = 1000;
  std::vector<Observation> many = observations();
  NumpyGenerator generator(20001);
  while (many.size() < kMany) {
    const std::vector<float> values = randomValues(generator, std::tuple_size<Observation>::value, 1.5);
    std::copy(values.begin(), values.end(), many.emplace_back().begin());
  }
  return many;
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

/// Runs a Python program of the tests, with these arguments. Throws if it fails.
inline void runPython(const std::string& arguments) {
  const std::string command = std::string(PUSHT_PYTHON) + " " + arguments + " 2>/dev/null";
  const int status = std::system(command.c_str());  // NOLINT(cert-env33-c): every word of it is ours
  if (status != 0) {
    throw std::runtime_error(command + " ends with " + std::to_string(status));
  }
}

/// Checkpoints that make_checkpoints.py writes, once for all tests.
inline const TemporaryFolder& checkpointsFromPython() {
  static const TemporaryFolder folder;
  static const bool written = (runPython(std::string(PUSHT_MAKE_CHECKPOINTS) + " " + (folder / "").string()), true);
  static_cast<void>(written);
  return folder;
}

/// Actions of rollouts that go on side by side for `steps`, `batch` of them in a call; [rollout][step]. A rollout's
/// observations follow from its index in `beginnings`.
inline std::vector<std::vector<Action>> drive(Policy& policy, const std::vector<Beginning>& beginnings, int steps,
                                              std::size_t batch) {
  const std::vector<Observation> all = observations();
  std::vector<std::unique_ptr<Policy::Memory>> memories;
  memories.reserve(beginnings.size());
  for (const Beginning& beginning : beginnings) {
    memories.push_back(policy.begin(beginning));
  }
  std::vector<std::vector<Action>> rollouts(beginnings.size());
  for (int step = 0; step < steps; ++step) {
    for (std::size_t first = 0; first < memories.size(); first += batch) {
      std::vector<Policy::Query> queries;
      for (std::size_t i = first; i < std::min(first + batch, memories.size()); ++i) {
        queries.push_back({all[(7 * i + static_cast<std::size_t>(step)) % all.size()], memories[i].get()});
      }
      std::vector<Action> actions(queries.size());
      policy.act(queries, actions);
      for (std::size_t i = 0; i < actions.size(); ++i) {
        rollouts[first + i].push_back(actions[i]);
      }
    }
  }
  return rollouts;
}

/// Equal to `tolerance`, relative where values exceed 1.
inline void expectNear(const std::vector<float>& actual, const std::vector<float>& expected, float tolerance) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    ASSERT_NEAR(actual[i], expected[i], tolerance * std::max(1.0F, std::abs(expected[i]))) << "value " << i;
  }
}

}  // namespace pusht::testing
