// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/agreement.hpp"

#include "sim2sim_statistics/common.hpp"

namespace sim2sim {
namespace {

Estimate estimateOf(const DistanceSamples& samples, const Quantity& quantity) {
  return meanOf(samples.divergence, quantity, averageOf(samples.null_model));
}

/// Mean over several distances, episode by episode.
DistanceSamples meanSamples(const std::vector<const DistanceSamples*>& distances) {
  const auto mean_of = [&](std::vector<double> DistanceSamples::*values) {
    std::vector<double> mean((distances.front()->*values).size(), 0.0);
    for (std::size_t episode = 0; episode < mean.size(); ++episode) {
      for (const DistanceSamples* distance : distances) {
        mean[episode] += (distance->*values)[episode];
      }
      mean[episode] /= static_cast<double>(distances.size());
    }
    return mean;
  };
  return {mean_of(&DistanceSamples::divergence), mean_of(&DistanceSamples::null_model)};
}

/// Mean distance of a simulator to all others, there and back.
DistanceSamples toOthers(const AgreementSamples& samples, std::size_t simulator) {
  std::vector<const DistanceSamples*> distances;
  for (std::size_t other = 0; other < samples.pairs.size(); ++other) {
    if (other != simulator) {
      distances.push_back(&samples.pairs[simulator][other]);
      distances.push_back(&samples.pairs[other][simulator]);
    }
  }
  return meanSamples(distances);
}

}  // namespace

AgreementFigures figuresOf(const AgreementSamples& samples, const Quantity& quantity) {
  AgreementFigures figures;
  std::vector<std::vector<double>> to_others;
  for (std::size_t i = 0; i < samples.pairs.size(); ++i) {
    std::vector<Estimate>& row = figures.distances.emplace_back(samples.pairs.size(), Estimate{0.0, std::nullopt});
    for (std::size_t j = 0; j < samples.pairs.size(); ++j) {
      if (j != i) {
        row[j] = estimateOf(samples.pairs[i][j], quantity);
      }
    }
    std::vector<Estimate>& variants = figures.variants.emplace_back();
    for (const DistanceSamples& variant : samples.variants[i]) {
      variants.push_back(estimateOf(variant, quantity));
    }
    const DistanceSamples others = toOthers(samples, i);
    figures.others.push_back(estimateOf(others, quantity));
    to_others.push_back(others.divergence);
  }
  figures.centrality = centralityOf(CrossedTable(to_others));
  return figures;
}

}  // namespace sim2sim
