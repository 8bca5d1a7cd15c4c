// SPDX-License-Identifier: BSD-3-Clause
/// Texts of a picture.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/summary.hpp"

namespace sim2sim {

/// Result of the finished episodes as text: a figure, shown large, and its interval, shown small.
struct Result {
  std::string figure{};
  std::string certainty{};
};

/// Result of the finished episodes in a world.
Result resultOf(Mode mode, const Summary& summary);

/// Source of a world's actions: "same policy", "same actions as MuJoCo".
std::string subtitleOf(Mode mode, const RunConfiguration& run);

/// Title of a world's simulator: "MuJoCo, the reference".
std::string titleOf(Mode mode, const RunConfiguration& run);

/// Parameters that differ from their defaults, in at most `lines` lines of at most `length` bytes: "block_damp 20.0".
/// The rest are counted: "and 3 more".
std::vector<std::string> changedParameters(const SimulatorRecord& simulator, std::size_t lines, std::size_t length);

/// Distance of a world's tee from the target [m, rad], whether that is a success, and whether it has left the table.
std::string statusOf(Mode mode, const Episode& episode);

/// Time and cause of the first divergence: "parts at 0.2 s: ..."; empty while the rollout is within the bound.
std::string firstDivergenceText(const std::optional<FirstDivergence>& first_divergence);

/// Time of a control step since the beginning of its episode: "3.9 s".
std::string secondsText(int steps);

}  // namespace sim2sim
