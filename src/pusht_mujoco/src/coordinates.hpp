// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace pusht {

/// Order of the coordinates, their velocities and their joints; the scene check holds the scene to it.
enum Coordinate { kTeeX, kTeeY, kTeeYaw, kPusherX, kPusherY };

}  // namespace pusht
