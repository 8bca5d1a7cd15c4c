// SPDX-License-Identifier: BSD-3-Clause
/// Work of the node that shows a recorded run.
#pragma once

#include "pusht_task/error.hpp"

namespace sim2sim {

/// Body of replay_node, after catchInterrupts().
pusht::ExitCode servePlayback();

}  // namespace sim2sim
