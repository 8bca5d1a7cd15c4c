// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pusht_task/simulator_kind.hpp"

/// A simulator without physics: the pusher goes where it is told and shoves the tee ahead of it.
const pusht::SimulatorKind& toyKind();
