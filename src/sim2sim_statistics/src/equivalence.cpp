// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/equivalence.hpp"

#include <cstddef>
#include <limits>

#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

/// Size between two at which the line from `before` > 0 to `after` <= 0 is 0.
double rootBetween(double low_size, double before, double high_size, double after) {
  return low_size + (high_size - low_size) * (before / (before - after));
}

/// Size at which `of` a surplus falls to 0 first.
template <class Of>
double firstRoot(const std::vector<Surplus>& surplus, const Of& of) {
  if (of(surplus.front()) <= 0.0) {
    return surplus.front().size;
  }
  for (std::size_t i = 1; i < surplus.size(); ++i) {
    if (of(surplus[i]) <= 0.0) {
      return rootBetween(surplus[i - 1].size, of(surplus[i - 1]), surplus[i].size, of(surplus[i]));
    }
  }
  return std::numeric_limits<double>::infinity();
}

/// Size at which `of` a surplus falls below 0 for good.
template <class Of>
double lastRoot(const std::vector<Surplus>& surplus, const Of& of) {
  if (of(surplus.back()) >= 0.0) {
    return std::numeric_limits<double>::infinity();
  }
  for (std::size_t i = surplus.size() - 1; i > 0; --i) {
    if (of(surplus[i - 1]) >= 0.0) {
      return rootBetween(surplus[i - 1].size, of(surplus[i - 1]), surplus[i].size, of(surplus[i]));
    }
  }
  return surplus.front().size;
}

}  // namespace

EquivalentSize equivalentSize(const std::vector<Surplus>& surplus) {
  if (surplus.size() < 2) {
    refuse("number of sizes", surplus.size(), "at least 2");
  }
  for (std::size_t i = 1; i < surplus.size(); ++i) {
    if (!(surplus[i - 1].size < surplus[i].size)) {
      refuse("size", surplus[i].size, "above the one before it, " + shortestText(surplus[i - 1].size));
    }
  }
  return {firstRoot(surplus, [](const Surplus& at) { return at.value; }),
          {firstRoot(surplus, [](const Surplus& at) { return at.interval.low; }),
           lastRoot(surplus, [](const Surplus& at) { return at.interval.high; })}};
}

}  // namespace sim2sim
