// SPDX-License-Identifier: BSD-3-Clause
/// What the bits of a run depend on, besides its configuration.
#pragma once

#include <nlohmann/json.hpp>

namespace sim2sim {

/// Version of the suite, compiler, libraries, CPU features.
nlohmann::json buildAndMachine();

}  // namespace sim2sim
