// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/equivalence.hpp"

#include <cstddef>
#include <limits>

#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

constexpr double kBeyond = std::numeric_limits<double>::infinity();  // the largest size

/// Size at which the surplus falls to 0 first, on lines between the sizes.
double firstRoot(const std::vector<Surplus>& surplus) {
  if (surplus.front().value <= 0.0) {
    return surplus.front().size;
  }
  for (std::size_t i = 1; i < surplus.size(); ++i) {
    const Surplus& before = surplus[i - 1];
    const Surplus& after = surplus[i];
    if (after.value <= 0.0) {
      return before.size + (after.size - before.size) * (before.value / (before.value - after.value));
    }
  }
  return kBeyond;
}

/// Largest size up to which the surplus is surely above 0 at each that was tried; the smallest if there is none.
double lowerEnd(const std::vector<Surplus>& surplus) {
  std::size_t first = 0;
  while (first < surplus.size() && surplus[first].interval.low > 0.0) {
    ++first;
  }
  if (first == surplus.size()) {
    return kBeyond;
  }
  return surplus[first == 0 ? 0 : first - 1].size;
}

/// Smallest size from which on the surplus is surely below 0 at each that was tried.
double upperEnd(const std::vector<Surplus>& surplus) {
  std::size_t sure = surplus.size();
  while (sure > 0 && surplus[sure - 1].interval.high < 0.0) {
    --sure;
  }
  if (sure == surplus.size()) {
    return kBeyond;
  }
  return surplus[sure].size;
}

}  // namespace

EquivalentSize equivalentSize(const std::vector<Surplus>& surplus) {
  if (surplus.size() < 2) {
    refuse("number of sizes", surplus.size(), "at least 2");
  }
  for (std::size_t i = 1; i < surplus.size(); ++i) {
    if (!(surplus[i - 1].size < surplus[i].size)) {
      refuse("size", surplus[i].size, "above the one before it,", surplus[i - 1].size);
    }
  }
  return {firstRoot(surplus), {lowerEnd(surplus), upperEnd(surplus)}};
}

}  // namespace sim2sim
