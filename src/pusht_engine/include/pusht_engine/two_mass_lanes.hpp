// SPDX-License-Identifier: BSD-3-Clause
/// The two-mass engine for many worlds, which step together in SIMD lanes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pusht_engine/simd.hpp"
#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_task/batch_simulator.hpp"
#include "pusht_task/spawn.hpp"

namespace pusht {

/// Worlds of the two-mass engine. Each lane has the bits of a TwoMassEngine.
class TwoMassLanes : public BatchSimulator {
 public:
  /// Throws InvalidInput if a parameter is out of range.
  explicit TwoMassLanes(int lanes, const TwoMassParameters& parameters = {});

  int lanes() const override { return static_cast<int>(states_.size()); }
  void reset(int lane, const WorldState& state) override;
  void spawn(int lane, std::uint64_t seed) override { reset(lane, pusht::spawn(seed)); }
  void step(Actions actions) override;
  WorldState state(int lane) const override;

 private:
  void stepGroup(std::size_t group, Actions actions);

  two_mass::Model model_;
  std::vector<two_mass::Bodies<simd::Lanes>> groups_;  // lane i is lane i % kLaneCount of group i / kLaneCount
  std::vector<WorldState> states_;
  LaneFaults faults_;
};

}  // namespace pusht
