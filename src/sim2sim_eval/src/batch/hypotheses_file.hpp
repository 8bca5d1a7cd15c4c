// SPDX-License-Identifier: BSD-3-Clause
/// Hypotheses from a file.
#pragma once

#include <filesystem>
#include <vector>

#include "sim2sim_protocol/results/hypotheses.hpp"

namespace sim2sim {

/// Reads hypotheses from YAML, a map of names to maps. Those of a difference between groups of policies have `more` and
/// `less` (groups), `in` (a simulator as the plan names it), `figure` (default: success) and, if need be, `paired:
/// true`. Those of a ranking have `ranking` (a list of groups), `here` and `there` (simulators). All have `side`
/// (`above` or `below`), or `within` (a number in the figure's unit). Throws InvalidInput with file, line, value and
/// rule.
std::vector<Hypothesis> readHypotheses(const std::filesystem::path& path);

}  // namespace sim2sim
