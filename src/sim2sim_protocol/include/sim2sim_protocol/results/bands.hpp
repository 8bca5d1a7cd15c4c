// SPDX-License-Identifier: BSD-3-Clause
/// Bands: quantiles of the divergence over time, over the episodes of a run; divergence.csv.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Contribution of an episode to the bands: for each rollout but the reference, for position and angle, the bin of its
/// divergence after each control step.
using EpisodeBins = std::vector<std::array<std::vector<std::uint16_t>, 2>>;

/// Bins as text, four hex digits for each.
nlohmann::json toJson(const EpisodeBins& bins);

/// Reads the JSON of toJson(). Throws json::exception or std::exception for any other.
EpisodeBins binsFrom(const nlohmann::json& json);

/// Histogram of the divergence after each control step, in bins whose edges are 2 % apart. Memory does not grow with
/// the number of episodes, and their order does not matter. Quantiles are right to 1 %.
class DivergenceBands {
 public:
  explicit DivergenceBands(const Protocol& protocol);

  /// Contribution of a finished episode of the protocol.
  static EpisodeBins binsOf(const Protocol& protocol, const Episode& episode);

  void add(const EpisodeBins& bins);
  void add(const Episode& episode) { add(binsOf(protocol_, episode)); }

  /// Text of divergence.csv: a row for each rollout but the reference and each control step, with the number of
  /// episodes that last so long and quantiles of their divergence [m, rad]. Values below 1e-12 are 0.
  std::string csv() const;

 private:
  using Bins = std::vector<std::uint32_t>;
  using Component = double Divergence::*;
  static constexpr std::array<Component, 2> kComponents = {&Divergence::position, &Divergence::angle};

  /// Histograms of one rollout, by control step.
  struct Curve {
    std::string mode;
    std::vector<std::array<Bins, kComponents.size()>> steps;
  };

  Protocol protocol_;
  std::vector<Curve> curves_;
};

}  // namespace sim2sim
