// SPDX-License-Identifier: BSD-3-Clause
/// Which row of a table is surely the lowest or the highest: of simulators by their distance to the others, the one in
/// the middle and the one at the edge. Functions throw std::domain_error, with value and rule, for input out of range.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim2sim_statistics/crossed.hpp"

namespace sim2sim {

/// Resamples behind the shares of Centrality. They give a share to 0.011 (one standard deviation), and better near 0
/// and 1.
constexpr int kCentralityResamples = 2000;
/// Seed of these resamples. Any will do, but results depend on it.
constexpr std::uint32_t kCentralitySeed = 1979;

/// Shares of resamples, from 0 to 1, in which a row is at either end; they add up to 1 over the rows.
struct Centrality {
  double most;   ///< share in which its mean is the lowest: it is the most central
  double least;  ///< share in which its mean is the highest: it is at the edge
};

/// Shares for each row of a table of mean distances to the others, by episode (column). Resamples draw as many columns
/// with replacement, the same ones for all rows, so what rows have in common does not count. Rows that tie have equal
/// parts. None below kFewestEpisodes columns.
/// Source: B. Efron, "Bootstrap Methods: Another Look at the Jackknife" (Annals of Statistics, 1979).
std::optional<std::vector<Centrality>> centralityOf(const CrossedTable& distances,
                                                    std::uint32_t seed = kCentralitySeed);

}  // namespace sim2sim
