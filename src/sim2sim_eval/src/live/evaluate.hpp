// SPDX-License-Identifier: BSD-3-Clause
/// Work of the evaluator's node.
#pragma once

#include "pusht_task/error.hpp"

namespace sim2sim {

/// Body of the evaluator's node, after catchInterrupts(). status.json tells the reason if it cannot start.
pusht::ExitCode evaluate();

}  // namespace sim2sim
