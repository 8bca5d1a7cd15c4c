// SPDX-License-Identifier: BSD-3-Clause
/// Divergence over time, as quantiles over the episodes of a run; divergence.csv.
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

/// What an episode adds to the bands: for each rollout that is compared with the reference, and for position and angle,
/// the bin of its divergence after each control step.
using EpisodeBins = std::vector<std::array<std::vector<std::uint16_t>, 2>>;

/// For each list of bins a text of four hex digits a bin.
nlohmann::json toJson(const EpisodeBins& bins);

/// Throws json::exception or std::exception if `json` does not come from toJson().
EpisodeBins binsFrom(const nlohmann::json& json);

/// Counts how many episodes diverge how far after each control step, in bins whose edges are 2 % apart: so its memory
/// does not grow with the episodes, and their order does not matter. Quantiles are right to 1 %.
class DivergenceBands {
 public:
  explicit DivergenceBands(const Protocol& protocol);

  /// What a finished episode of the protocol adds.
  static EpisodeBins binsOf(const Protocol& protocol, const Episode& episode);

  void add(const EpisodeBins& bins);
  void add(const Episode& episode) { add(binsOf(protocol_, episode)); }

  /// A row for each rollout that is compared with the reference and each control step: how many episodes go on, and
  /// quantiles of their divergences. Values below 1e-12 are 0.
  std::string csv() const;

 private:
  using Bins = std::vector<std::uint32_t>;
  using Component = double Divergence::*;
  static constexpr std::array<Component, 2> kComponents = {&Divergence::position, &Divergence::angle};

  /// Of one rollout.
  struct Curve {
    std::string mode;
    std::vector<std::array<Bins, kComponents.size()>> steps;
  };

  Protocol protocol_;
  std::vector<Curve> curves_;
};

}  // namespace sim2sim
