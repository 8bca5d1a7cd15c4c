// SPDX-License-Identifier: BSD-3-Clause
/// Provenance of a run: what its bits depend on besides its configuration.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/output_folder.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// Content of provenance.json: the descriptions that policy, reference and engine give of themselves (a simulator's
/// with its "version"), and those of build and machine.
nlohmann::ordered_json provenance(const RunConfiguration& configuration, const nlohmann::json& policy,
                                  const nlohmann::json& reference, const nlohmann::json& engine);

/// Version of the suite, compiler, libraries and CPU features.
nlohmann::json buildAndMachine();

/// Files in a simulator's `provenance`: {PARAMETER: {"file": PATH, ...}, ...}.
std::vector<Input> filesIn(const nlohmann::json& provenance);

/// Fingerprint of the code that computes bits: SHA-256 of `libraries` as they are loaded, by name ("libm.so"), and of
/// every loaded library whose name begins with one of `if_loaded`; and whether libm uses FMA. Throws InternalError if
/// one of `libraries` is not loaded.
nlohmann::json codeFingerprint(const std::vector<std::string>& libraries,
                               const std::vector<std::string>& if_loaded = {});

}  // namespace sim2sim
