// SPDX-License-Identifier: BSD-3-Clause
/// What the bits of a run depend on, besides its configuration.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "sim2sim_protocol/results/output_folder.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"

namespace sim2sim {

/// provenance.json of a run: what policy, reference and engine say of themselves (of a simulator its "version", too),
/// and what holds for all.
nlohmann::ordered_json provenance(const RunConfiguration& configuration, const nlohmann::json& policy,
                                  const nlohmann::json& reference, const nlohmann::json& engine);

/// Version of the suite, compiler, libraries, CPU features.
nlohmann::json buildAndMachine();

/// The files of a simulator's `provenance`: {PARAMETER: {"file": PATH, ...}, ...}.
std::vector<Input> filesIn(const nlohmann::json& provenance);

/// What decides the bits that code computes: SHA-256 of `libraries` as they are loaded, by name (e.g. "libm.so"), and
/// whether libm uses FMA; also of each library that is loaded under a name that begins with one of `if_loaded`. Throws
/// InternalError if one of `libraries` is not loaded.
nlohmann::json codeFingerprint(const std::vector<std::string>& libraries,
                               const std::vector<std::string>& if_loaded = {});

}  // namespace sim2sim
