// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_statistics/centrality.hpp"

#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <cstddef>

#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {
namespace {

/// Adds one resample's part to `share` of each row whose sum is `end`.
void addEnd(const std::vector<double>& sums, double end, double Centrality::*share, std::vector<Centrality>& shares) {
  const auto ties = static_cast<double>(std::count(sums.begin(), sums.end(), end));
  for (std::size_t row = 0; row < sums.size(); ++row) {
    if (sums[row] == end) {
      shares[row].*share += 1.0 / (ties * kCentralityResamples);
    }
  }
}

}  // namespace

std::optional<std::vector<Centrality>> centralityOf(const CrossedTable& distances, std::uint32_t seed) {
  if (distances.columns() < kFewestEpisodes) {
    return std::nullopt;
  }
  boost::random::mt19937 random(seed);
  const boost::random::uniform_int_distribution<std::size_t> any(0, distances.columns() - 1);
  std::vector<Centrality> shares(distances.rows(), Centrality{0.0, 0.0});
  std::vector<double> sums(distances.rows());
  for (int resample = 0; resample < kCentralityResamples; ++resample) {
    std::fill(sums.begin(), sums.end(), 0.0);
    for (std::size_t i = 0; i < distances.columns(); ++i) {
      const std::size_t column = any(random);
      for (std::size_t row = 0; row < sums.size(); ++row) {
        sums[row] += distances.at(row, column);
      }
    }
    const auto [least, most] = std::minmax_element(sums.begin(), sums.end());
    addEnd(sums, *least, &Centrality::most, shares);
    addEnd(sums, *most, &Centrality::least, shares);
  }
  return shares;
}

}  // namespace sim2sim
