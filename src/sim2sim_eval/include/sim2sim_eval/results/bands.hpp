// SPDX-License-Identifier: BSD-3-Clause
/// Divergence over time, as quantiles over the episodes of a run; divergence.csv.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sim2sim_eval/protocol/protocol.hpp"

namespace sim2sim {

/// Counts how many episodes diverge how far after each control step, in bins whose edges are 2 % apart: so its memory
/// does not grow with the episodes, and their order does not matter. Quantiles are right to 1 %.
class DivergenceBands {
 public:
  explicit DivergenceBands(const Protocol& protocol);

  /// A finished episode of the protocol.
  void add(const Episode& episode);

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

  static void add(Curve& curve, const pusht::Trace& reference, const pusht::Trace& rollout);

  std::vector<Curve> curves_;
};

}  // namespace sim2sim
