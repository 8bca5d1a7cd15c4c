// SPDX-License-Identifier: BSD-3-Clause
/// Divergence over time, drawn into a picture.
#pragma once

#include <vector>

#include "sim2sim_eval/live/sheet.hpp"
#include "sim2sim_eval/protocol/protocol.hpp"

namespace sim2sim {

// Where the strips are in the frame of their sheet [m].
constexpr double kStripsTop = -0.53;
constexpr double kStripsBottom = -0.97;

/// Paper, axes and titles of the two strips, position above angle.
void drawAxes(Sheet& sheet);

/// The curves of `modes` against the reference, their last values, the first from the right, and a mark where each of
/// them leaves `bound`.
void drawCurves(Sheet& sheet, const Episode& episode, const std::vector<Mode>& modes, const Bound& bound);

}  // namespace sim2sim
