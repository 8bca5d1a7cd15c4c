// SPDX-License-Identifier: BSD-3-Clause
/// Legend of a picture.
#pragma once

#include <Eigen/Core>

#include "live/canvas.hpp"

namespace sim2sim {

/// Draws each shape with its meaning beside it, in `columns` columns, from the upper left `corner` on [m].
void drawLegend(Canvas& canvas, const Eigen::Vector2d& corner, int columns);

}  // namespace sim2sim
